#include "common/map/targets.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "common/map/panorama.h"
#include "common/map/region_cells.h"
#include "common/map/visibility.h"

namespace muster::map {
namespace {

constexpr int kSearchesPerUpdate = 3;  // new or changed clusters
constexpr int kSearchesWhenIdle = 24;  // nothing else to go to: the robot waits for these
constexpr std::uint64_t kGrowthThatMatters =
    40;                           // voxels become known: refused clusters are tried again
constexpr int kVisitsInVain = 4;  // counted 2 for a scan from the very viewpoint, 1 from near it
constexpr int kLooksInVain = 2;   // a look is all or nothing: the next shows the same
constexpr double kLeastPromise_m2 = 0.12;
constexpr double kSliver = 0.3;  // of the smallest cluster
constexpr double kSameClusterM = 1.0, kMovedM = 0.3;

struct Tracked {
  CellCluster cluster;
  Vec3 centroid = Vec3::Zero();
  std::uint32_t id = 0;
  bool surface = false;
  double promise_m2 = 0;  ///< of a surface
  std::vector<Viewpoint> views;
  std::vector<Vec3> avoid;  ///< viewpoints that brought nothing
  bool searched = false;    ///< for these very cells
  std::uint64_t searched_growth = 0;
  std::size_t searched_cells = 0;
  Vec3 searched_centroid = Vec3::Zero();
  int visits = 0;
  std::size_t cells_at_visit = 0;
  bool exhausted = false;  ///< looked at from its viewpoints, in vain
};

bool alike(std::size_t a, std::size_t b) { return std::max(a, b) * 4 <= std::min(a, b) * 5; }
bool similar(std::size_t a, std::size_t b) { return std::max(a, b) * 10 <= std::min(a, b) * 11; }

}  // namespace

struct Targets::Impl {
  Impl(const VoxelMap& m, const Box& b, const TargetConfig& c)
      : map(m),
        config(c),
        cells(m, b, c.looks, c.max_cluster_extent_m),
        search(m, cells, c),
        panorama(m, cells, c) {}

  struct Look {
    Pose sensor;
    double pitch_rad;
  };

  const VoxelMap& map;
  TargetConfig config;
  RegionCells cells;
  ViewpointSearch search;
  PanoramaReader panorama;
  std::vector<Pose> scans;
  Vec3 last_seen_from = Vec3::Zero();
  std::vector<Look> looks, past_looks;
  std::vector<Tracked> frontier, owed;
  std::uint32_t next_id = 1;
  std::vector<Viewpoint> viewpoints;
  std::vector<Refused> refused;
  double frontier_m2 = 0, owed_m2 = 0;
  double least_promise_m2 = kLeastPromise_m2;
  bool done = false;

  double area_m2(const Tracked& t) const {
    return static_cast<double>(t.cluster.cells.size()) * map.config().resolution_m *
           map.config().resolution_m;
  }
  /// What a cluster must be worth: frontier, or what looks promise.
  double least_m2(const Tracked& t) const {
    return t.surface ? least_promise_m2 : config.min_cluster_m2;
  }
  /// A sliver beside a larger part of its group is left: on its own it would be too small.
  bool is_owed(const Tracked& t) const {
    if (t.surface) return t.promise_m2 >= least_promise_m2;
    return t.cluster.group_m2 >= config.min_cluster_m2 - 1e-9 &&
           area_m2(t) >= kSliver * config.min_cluster_m2;
  }

  void take_scans();
  void take_looks();
  void credit_past_looks();
  void visit(std::vector<Tracked>& clusters, const Pose& sensor,
             const std::vector<VoxelKey>& progress);
  void track(CellClusters& source, bool surface, std::vector<Tracked>& tracked);
  void weigh();
  void drop_blocked_views(std::vector<Tracked>& tracked);
  void search_viewpoints(const std::function<bool(const Vec3&)>& reachable);
  void sum_up();
};

void Targets::Impl::take_scans() {
  for (const Pose& sensor : scans) {
    // What this scan should have made known and did not.
    FieldOfView fov = search.reliable(false);
    fov.range_m *= 0.97;
    std::vector<VoxelKey> stubborn;
    cells.near(cells.frontier(), sensor.p, fov.range_m, [&](VoxelKey k) {
      if (!fov.contains(sensor, config.pitch_rad, map.center(k))) return;
      if (sighted(map, frontier_aim(map, cells, k), sensor.p, fov.range_m)) stubborn.push_back(k);
    });
    for (const VoxelKey& k : stubborn) cells.looked_in_vain(k);
    visit(frontier, sensor, {});
    last_seen_from = sensor.p;
  }
  scans.clear();
}

void Targets::Impl::take_looks() {
  for (const Look& look : looks) {
    const FieldOfView fov = search.reliable(true);
    std::vector<VoxelKey> seen;
    std::vector<FaceSet> faces;
    cells.near(cells.owed(), look.sensor.p, fov.range_m, [&](VoxelKey k) {
      if (!fov.contains(look.sensor, look.pitch_rad, map.center(k))) return;
      const FaceSet in_view =
          faces_sighted(map, surface_aim(map, cells, k), look.sensor.p, fov.range_m);
      if (in_view == 0) return;
      seen.push_back(k);
      faces.push_back(in_view);
    });
    for (std::size_t i = 0; i < seen.size(); ++i)
      cells.count_look(seen[i], faces[i], look.sensor.p);
    visit(owed, look.sensor, seen);
  }
  past_looks.insert(past_looks.end(), looks.begin(), looks.end());
  looks.clear();
}

/// A surface that has just become known may have been in view of the detector before: the last
/// looks count for it as well.
void Targets::Impl::credit_past_looks() {
  const FieldOfView fov = search.reliable(true);
  for (const VoxelKey& k : cells.take_new_surface()) {
    const Vec3 p = map.center(k);
    Aim aim = surface_aim(map, cells, k);
    for (std::size_t i = past_looks.size(); i-- > 0 && !aim.spots.empty();) {
      const Look& look = past_looks[i];
      if ((p - look.sensor.p).squaredNorm() > fov.range_m * fov.range_m) continue;
      if (!fov.contains(look.sensor, look.pitch_rad, p)) continue;
      const FaceSet in_view = faces_sighted(map, aim, look.sensor.p, fov.range_m);
      if (in_view == 0) continue;
      cells.count_look(k, in_view, look.sensor.p);
      aim = surface_aim(map, cells, k);
    }
  }
}

void Targets::Impl::visit(std::vector<Tracked>& clusters, const Pose& sensor,
                          const std::vector<VoxelKey>& progress) {
  for (Tracked& t : clusters) {
    const auto is_own = [&](const VoxelKey& k) {
      return std::find(t.cluster.cells.begin(), t.cluster.cells.end(), k) != t.cluster.cells.end();
    };
    for (std::size_t v = 0; v < t.views.size(); ++v) {
      const double off_m = (t.views[v].pose.p - sensor.p).norm();
      const double off_rad = std::abs(wrap_angle(t.views[v].pose.yaw_rad - sensor.yaw_rad));
      if (off_m > 0.5 || off_rad > 0.3) continue;
      if (std::any_of(progress.begin(), progress.end(), is_own)) break;
      if (t.visits == 0 || !similar(t.cells_at_visit, t.cluster.cells.size())) {
        t.visits = 0;
        t.cells_at_visit = t.cluster.cells.size();
      }
      t.visits += off_m < 0.25 && off_rad < 0.15 ? 2 : 1;
      if (t.visits < (t.surface ? kLooksInVain : kVisitsInVain)) break;
      // Once more from elsewhere, then enough.
      t.exhausted = !t.avoid.empty();
      t.avoid.push_back(t.views[v].pose.p);
      t.views.clear();
      t.searched = false;
      t.visits = 0;
      break;
    }
  }
}

void Targets::Impl::track(CellClusters& source, bool surface, std::vector<Tracked>& tracked) {
  if (!source.changed()) return;
  std::vector<Tracked> old = std::move(tracked);
  tracked.clear();
  std::map<std::uint64_t, std::size_t> by_fingerprint;
  for (std::size_t i = 0; i < old.size(); ++i)
    by_fingerprint.emplace(old[i].cluster.fingerprint, i);
  std::vector<bool> taken(old.size(), false);
  std::vector<CellCluster> fresh;
  for (CellCluster& c : source.clusters()) {
    const auto it = by_fingerprint.find(c.fingerprint);
    if (it == by_fingerprint.end() || taken[it->second]) {
      fresh.push_back(std::move(c));
      continue;
    }
    taken[it->second] = true;
    tracked.push_back(std::move(old[it->second]));
    tracked.back().cluster = std::move(c);
  }
  for (CellCluster& c : fresh) {
    Tracked t;
    t.surface = surface;
    for (const VoxelKey& k : c.cells) t.centroid += map.center(k);
    t.centroid /= static_cast<double>(c.cells.size());
    t.cluster = std::move(c);
    // What is left of an older one, or has grown from it, keeps its number and until it is searched
    // its viewpoints.
    std::size_t nearest = old.size();
    double nearest_m = kSameClusterM;
    for (std::size_t i = 0; i < old.size(); ++i) {
      const double m = (old[i].centroid - t.centroid).norm();
      if (!taken[i] && m < nearest_m) {
        nearest = i;
        nearest_m = m;
      }
    }
    if (nearest < old.size()) {
      taken[nearest] = true;
      Tracked& o = old[nearest];
      t.id = o.id;
      t.views = std::move(o.views);
      t.searched_growth = o.searched_growth;
      t.searched_cells = o.searched_cells;
      t.searched_centroid = o.searched_centroid;
      // A cluster that lost or won a few cells is still best seen from where it was.
      t.searched = o.searched && !t.views.empty() &&
                   alike(o.searched_cells, t.cluster.cells.size()) &&
                   (o.searched_centroid - t.centroid).norm() < kMovedM;
      if (similar(o.cluster.cells.size(), t.cluster.cells.size())) {
        t.avoid = std::move(o.avoid);
        t.exhausted = o.exhausted;
        t.visits = o.visits;
        t.cells_at_visit = o.cells_at_visit;
      }
    } else {
      t.id = next_id++;
    }
    tracked.push_back(std::move(t));
  }
  std::sort(tracked.begin(), tracked.end(),
            [](const Tracked& a, const Tracked& b) { return a.id < b.id; });
  if (surface) weigh();
}

void Targets::Impl::weigh() {
  const double cell_m2 = map.config().resolution_m * map.config().resolution_m;
  for (Tracked& t : owed) {
    t.promise_m2 = 0;
    for (const VoxelKey& k : t.cluster.cells) t.promise_m2 += cell_m2 * cells.promise(k);
  }
}

void Targets::Impl::drop_blocked_views(std::vector<Tracked>& tracked) {
  for (Tracked& t : tracked) {
    const std::size_t before = t.views.size();
    std::erase_if(t.views, [&](const Viewpoint& v) { return !map.traversable(v.pose.p); });
    if (t.views.size() != before) t.searched = false;
  }
}

void Targets::Impl::search_viewpoints(const std::function<bool(const Vec3&)>& reachable) {
  bool anything = false;
  for (const auto* list : {&frontier, &owed}) {
    for (const Tracked& t : *list) anything |= !t.views.empty() && is_owed(t);
  }
  int budget = anything ? kSearchesPerUpdate : kSearchesWhenIdle;
  // What never was searched before what changed before what was refused; the near before the far,
  // where the robot may go next.
  struct Waiting {
    int rank;
    double off_m;
    Tracked* cluster;
  };
  std::vector<Waiting> queue;
  for (auto* list : {&frontier, &owed}) {
    for (Tracked& t : *list) {
      if (!is_owed(t) || t.exhausted) continue;
      const bool stale =
          t.views.empty() && cells.growth() >= t.searched_growth + kGrowthThatMatters;
      if (t.searched && !stale) continue;
      queue.push_back({t.searched        ? 2
                       : t.views.empty() ? 0
                                         : 1,
                       (t.centroid - last_seen_from).norm(), &t});
    }
  }
  std::stable_sort(queue.begin(), queue.end(), [](const Waiting& a, const Waiting& b) {
    if (a.rank != b.rank) return a.rank < b.rank;
    if (a.rank == 2) return a.cluster->searched_growth < b.cluster->searched_growth;
    return a.off_m < b.off_m;
  });
  for (auto& [rank, off_m, t] : queue) {
    if (budget-- == 0) break;
    t->views = search.find({&t->cluster.cells, t->surface, &t->avoid, least_m2(*t)}, reachable);
    for (Viewpoint& v : t->views) v.cluster = t->id;
    t->searched = true;
    t->searched_growth = cells.growth();
    t->searched_cells = t->cluster.cells.size();
    t->searched_centroid = t->centroid;
  }
}

void Targets::Impl::sum_up() {
  viewpoints.clear();
  refused.clear();
  frontier_m2 = owed_m2 = 0;
  done = cells.any_known();
  for (const auto* list : {&frontier, &owed}) {
    for (const Tracked& t : *list) {
      const double area = area_m2(t);
      const auto refuse = [&](std::string reason) {
        refused.push_back({t.centroid, area, std::move(reason)});
      };
      const std::string what = t.surface ? "surface" : "frontier";
      if (!is_owed(t)) {
        char least[32];
        std::snprintf(least, sizeof least, "%.2f m²", least_m2(t));
        refuse(what + (t.surface ? ": looks promise less than " : ": smaller than ") + least);
      } else if (t.exhausted) {
        refuse(what + ": looked at from its viewpoints, nothing became known");
      } else if (!t.views.empty()) {
        viewpoints.insert(viewpoints.end(), t.views.begin(), t.views.end());
        (t.surface ? owed_m2 : frontier_m2) += area;
        done = false;
      } else if (t.searched && cells.growth() < t.searched_growth + kGrowthThatMatters) {
        refuse(what +
               (t.surface ? ": no reachable pose gives a look" : ": no reachable pose sees it"));
      } else {
        (t.surface ? owed_m2 : frontier_m2) += area;
        done = false;  // not searched yet
      }
    }
  }
}

Targets::Targets(const VoxelMap& map, const Box& box, const TargetConfig& config)
    : impl_(std::make_unique<Impl>(map, box, config)) {}
Targets::~Targets() = default;

void Targets::looked(const Pose& sensor, double pitch_rad) {
  impl_->looks.push_back({sensor, pitch_rad});
}
void Targets::scanned(const Pose& sensor) { impl_->scans.push_back(sensor); }

void Targets::ask_for(double promise_m2, bool nooks) {
  Impl& t = *impl_;
  t.least_promise_m2 = promise_m2;
  if (nooks == t.cells.nooks_asked()) return;
  t.cells.ask_for_nooks(nooks);
  t.weigh();
  for (Tracked& c : t.owed) c.searched = c.searched && !c.views.empty();
}

void Targets::settle() {
  Impl& t = *impl_;
  t.cells.update();
  t.take_scans();
  t.credit_past_looks();
  t.take_looks();
  t.cells.settle();
}

Panorama Targets::panorama(const Vec3& eye) const { return impl_->panorama.around(eye); }
Worth Targets::worth(const Pose& pose) const { return impl_->panorama.at(pose); }

void Targets::update(const std::function<bool(const Vec3&)>& reachable) {
  settle();
  Impl& t = *impl_;
  t.track(t.cells.frontier(), false, t.frontier);
  t.track(t.cells.owed(), true, t.owed);
  t.drop_blocked_views(t.frontier);
  t.drop_blocked_views(t.owed);
  t.search_viewpoints(reachable);
  t.sum_up();
}

const std::vector<Viewpoint>& Targets::viewpoints() const { return impl_->viewpoints; }
const std::vector<Refused>& Targets::refused() const { return impl_->refused; }
bool Targets::done() const { return impl_->done; }
double Targets::frontier_m2() const { return impl_->frontier_m2; }
double Targets::owed_surface_m2() const { return impl_->owed_m2; }
double Targets::surface_m2() const {
  const double cell_m2 = std::pow(impl_->map.config().resolution_m, 2);
  return static_cast<double>(impl_->cells.surfaces()) * cell_m2;
}
std::uint64_t Targets::looks_counted() const { return impl_->cells.looks_counted(); }

}  // namespace muster::map
