#include "common/map/visibility.h"

#include <algorithm>
#include <cmath>

#include "common/map/voxel_reader.h"

namespace muster::map {
namespace {

constexpr std::size_t kAims = 14;  // cells of a cluster that stand for all of it
constexpr int kBearings = 12;
constexpr double kDistancesM[] = {0.8, 1.5, 2.4, 3.5};
constexpr double kSlopes[] = {0, 0.3, -0.3};  // height over distance
constexpr double kEnough = 0.6;     // a first viewpoint that sees this share needs no second
constexpr double kGoodShare = 0.6;  // of the best score: among these, what else is in view decides
constexpr std::size_t kFinalists = 12;
constexpr double kAvoidM = 0.5;
constexpr double kUpperEdge = 0.4;  // voxels above the middle

bool shows(const VoxelMap& map, const Aim::Spot& s, const Vec3& eye, double range_m) {
  const Vec3 way = eye - s.at;
  if (way.squaredNorm() > range_m * range_m) return false;
  if (s.face >= 0 && way.normalized().dot(face_normal(s.face)) <= kLeastFacing) return false;
  return map.line_of_sight(eye, s.at, false);
}

}  // namespace

Aim frontier_aim(const VoxelMap& map, const RegionCells& cells, VoxelKey k) {
  Aim aim{k, 1, 0, {}};
  for (const VoxelKey& d : kFaces) {
    const VoxelKey u{k.x + d.x, k.y + d.y, k.z + d.z};
    if (cells.unknown_in_box(u)) aim.spots.push_back({map.center(u), -1});
  }
  return aim;
}

Aim surface_aim(const VoxelMap& map, const RegionCells& cells, VoxelKey k) {
  Aim aim{k, cells.promise(k), cells.exhausted_sectors(k), {}};
  const FaceSet owed = cells.owed_faces(k);
  for (int face = 0; face < 6; ++face) {
    if ((owed >> face & 1) == 0) continue;
    Vec3 off = 0.55 * face_normal(face);
    if (cells.overhung(k, face)) off.z() = kUpperEdge;
    aim.spots.push_back({map.center(k) + map.config().resolution_m * off, face});
  }
  return aim;
}

bool sighted(const VoxelMap& map, const Aim& aim, const Vec3& eye, double range_m) {
  if ((aim.exhausted & sector_of(eye - map.center(aim.cell))) != 0) return false;
  return std::ranges::any_of(aim.spots,
                             [&](const Aim::Spot& s) { return shows(map, s, eye, range_m); });
}

FaceSet faces_sighted(const VoxelMap& map, const Aim& aim, const Vec3& eye, double range_m) {
  FaceSet faces = 0;
  if ((aim.exhausted & sector_of(eye - map.center(aim.cell))) != 0) return 0;
  for (const Aim::Spot& s : aim.spots) {
    if (shows(map, s, eye, range_m)) faces = static_cast<FaceSet>(faces | 1u << s.face);
  }
  return faces;
}

ViewpointSearch::ViewpointSearch(const VoxelMap& map, RegionCells& cells,
                                 const TargetConfig& config)
    : map_(map), cells_(cells), config_(config) {}

FieldOfView ViewpointSearch::reliable(bool surface) const {
  FieldOfView fov = config_.camera;
  fov.hfov_rad *= 0.94;
  fov.vfov_rad *= 0.94;
  fov.range_m = surface ? std::min(config_.look_range_m, config_.camera.range_m)
                        : 0.93 * config_.camera.range_m;
  return fov;
}

std::vector<Aim> ViewpointSearch::aims(const Cluster& cluster) const {
  const std::size_t n = cluster.cells->size(), take = std::min(n, kAims);
  std::vector<Aim> result;
  for (std::size_t i = 0; i < take; ++i) {
    const VoxelKey k = (*cluster.cells)[i * n / take];
    result.push_back(cluster.surface ? surface_aim(map_, cells_, k)
                                     : frontier_aim(map_, cells_, k));
  }
  return result;
}

std::optional<ViewpointSearch::Candidate> ViewpointSearch::judge(const std::vector<Aim>& aims,
                                                                 const Vec3& eye,
                                                                 bool surface) const {
  const FieldOfView fov = reliable(surface);
  const double steepest = std::tan(fov.vfov_rad / 2);
  struct Seen {
    double az;
    std::uint32_t aim;
  };
  double all = 0;
  for (const Aim& a : aims) all += a.weight;
  std::vector<Seen> seen;
  for (std::uint32_t i = 0; i < aims.size(); ++i) {
    const Vec3 d = map_.center(aims[i].cell) - eye;
    const double flat = std::hypot(d.x(), d.y());
    // Cheap first: what no heading brings into view needs no line of sight.
    if (config_.pitch_rad == 0 && std::abs(d.z()) > flat * steepest) continue;
    if (sighted(map_, aims[i], eye, fov.range_m)) seen.push_back({std::atan2(d.y(), d.x()), i});
  }
  if (seen.empty()) return std::nullopt;
  // The heading whose field of view holds the most: it may start at any of them.
  double best = 0, best_yaw = 0;
  for (const Seen& start : seen) {
    double sum = 0, last = 0;
    for (const Seen& s : seen) {
      double off = s.az - start.az;
      if (off < -1e-12) off += 2 * std::numbers::pi;
      if (off > fov.hfov_rad) continue;
      sum += aims[s.aim].weight;
      last = std::max(last, off);
    }
    if (sum > best) {
      best = sum;
      best_yaw = wrap_angle(start.az + last / 2);
    }
  }
  Candidate c;
  c.pose = {eye, best_yaw};
  for (const Seen& s : seen) {
    if (!fov.contains(c.pose, config_.pitch_rad, map_.center(aims[s.aim].cell))) continue;
    c.sees.push_back(s.aim);
    c.score += aims[s.aim].weight / all;
  }
  if (c.sees.empty()) return std::nullopt;
  return c;
}

double ViewpointSearch::area_in_view(const Pose& pose, bool surface) const {
  const FieldOfView fov = reliable(surface);
  const double cell_m2 = map_.config().resolution_m * map_.config().resolution_m;
  // Every third cell stands for three.
  constexpr int kStride = 3;
  int n = 0;
  double seen = 0;
  cells_.near(surface ? cells_.owed() : cells_.frontier(), pose.p, fov.range_m, [&](VoxelKey k) {
    if (n++ % kStride != 0 || !fov.contains(pose, config_.pitch_rad, map_.center(k))) return;
    const Aim aim = surface ? surface_aim(map_, cells_, k) : frontier_aim(map_, cells_, k);
    if (sighted(map_, aim, pose.p, fov.range_m)) seen += aim.weight;
  });
  return seen * kStride * cell_m2;
}

double ViewpointSearch::volume_in_view(const Pose& pose) const {
  constexpr int kColumns = 8, kRows = 6;
  constexpr double kStepM = 0.4;
  const FieldOfView& fov = config_.camera;
  const double cell_rad2 = fov.hfov_rad / kColumns * fov.vfov_rad / kRows;
  VoxelReader reader(map_);
  double volume_m3 = 0;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const double az = fov.hfov_rad * (0.5 - (c + 0.5) / kColumns),
                   el = fov.vfov_rad * ((r + 0.5) / kRows - 0.5);
      const Vec3 direction = ray_direction(pose.yaw_rad, config_.pitch_rad, az, el);
      for (int i = 1; i * kStepM < fov.range_m; ++i) {
        const double d = i * kStepM;
        const VoxelKey k = map_.key(pose.p + d * direction);
        const Voxel v = reader.at(k);
        if (v == Voxel::kOccupied) break;
        if (v == Voxel::kUnknown && cells_.unknown_in_box(k))
          volume_m3 += d * d * kStepM * cell_rad2 * std::cos(el);
      }
    }
  }
  return volume_m3;
}

std::vector<Viewpoint> ViewpointSearch::find(
    const Cluster& cluster, const std::function<bool(const Vec3&)>& reachable) const {
  const std::vector<Aim> targets = aims(cluster);
  Vec3 centroid = Vec3::Zero();
  for (const Aim& a : targets)
    centroid += map_.center(a.cell) / static_cast<double>(targets.size());
  std::vector<Candidate> candidates;
  std::vector<VoxelKey> tried;
  for (std::size_t ring = 0; ring < std::size(kDistancesM); ++ring) {
    for (int b = 0; b < kBearings; ++b) {
      const double az =
          (b + 0.5 * static_cast<double>(ring % 2)) * 2 * std::numbers::pi / kBearings;
      for (const double slope : kSlopes) {
        if (map_.config().ground && slope != 0) continue;
        Vec3 p = centroid + kDistancesM[ring] * Vec3(std::cos(az), std::sin(az), slope);
        if (map_.config().ground) p.z() = map_.config().ride_height_m;
        const VoxelKey k = map_.body_key(p);
        if (!map_.traversable(k) || std::find(tried.begin(), tried.end(), k) != tried.end())
          continue;
        tried.push_back(k);
        p = map_.center(k);
        const bool useless = std::ranges::any_of(
            *cluster.avoid, [&](const Vec3& a) { return (a - p).norm() < kAvoidM; });
        if (useless || !reachable(p)) continue;
        if (auto c = judge(targets, p, cluster.surface)) candidates.push_back(std::move(*c));
      }
    }
  }
  double cluster_m2 = 0;
  for (const VoxelKey& k : *cluster.cells) cluster_m2 += cluster.surface ? cells_.promise(k) : 1;
  cluster_m2 *= map_.config().resolution_m * map_.config().resolution_m;
  // A pose for a few voxels of a cluster is not worth the way.
  const double least_share = std::min(0.5, 0.5 * cluster.least_m2 / cluster_m2);
  std::erase_if(candidates, [&](const Candidate& c) { return c.score < least_share; });
  if (candidates.empty()) return {};
  const auto better = [](const Candidate& a, const Candidate& b) { return a.score > b.score; };
  std::stable_sort(candidates.begin(), candidates.end(), better);
  // The cluster comes first, but among poses that see it well the one that looks into most counts.
  std::size_t best = 0;
  double best_value = -1;
  for (std::size_t i = 0; i < std::min(kFinalists, candidates.size()); ++i) {
    const Candidate& c = candidates[i];
    if (c.score < kGoodShare * candidates[0].score) break;
    const double worth = cluster.surface ? area_in_view(c.pose, true) : volume_in_view(c.pose);
    const double value = (worth + 0.5) * c.score;
    if (value > best_value) {
      best = i;
      best_value = value;
    }
  }
  const double best_gain = std::max(candidates[best].score * cluster_m2,
                                    area_in_view(candidates[best].pose, cluster.surface));
  const Candidate first = candidates[best];
  std::vector<Viewpoint> result{{first.pose, best_gain, cluster.surface, 0}};
  if (first.score >= kEnough) return result;
  // A second one for what the first does not see.
  const auto news = [&](const Candidate& c) {
    return std::ranges::count_if(
        c.sees, [&](std::uint32_t a) { return !std::ranges::binary_search(first.sees, a); });
  };
  const Candidate* second = nullptr;
  for (const Candidate& c : candidates) {
    if (news(c) >= 2 && (!second || news(c) > news(*second))) second = &c;
  }
  if (second) result.push_back({second->pose, second->score * cluster_m2, cluster.surface, 0});
  return result;
}

}  // namespace muster::map
