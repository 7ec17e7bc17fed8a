#include "agent/strategy/view_poses.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "common/map/planes.h"

namespace muster::agent {
namespace {

constexpr double kGap_m = 0.3;  // the line of sight is asked for up to this far before the surface,
                                // whose voxels are occupied
// A surface seen at a slant is thick with voxels for as far as this before the area: that hides it
// on the map, but not always in the world.
constexpr double kSlantGap_m = 0.8;
constexpr double kSlantClear = 0.4;
constexpr double kRefusal_s = 14;  // an attempt in vain: the hold, and the way to the next
constexpr double kLeastChance[] = {0.25, 0.08, 0.02, 0.004};
// After a refusal something that the map is too coarse for may hide the area: what was open along
// the sighting's line is open beside it, and less and less further off.
constexpr double kOpenBeside_rad = 0.7;
constexpr double kOpenAnywhere = 0.15;
constexpr double kSamePose_rad = 0.06, kSamePose_m = 0.3;  // shows the same again
constexpr double kSameLook_rad = 0.2;                      // what was wrong there may be wrong here
constexpr double kSameLook = 0.92;                         // how surely, at the very same direction
constexpr double kRanges_m[] = {1.2, 1.6, 2.1, 2.7, 3.4, 4.1, 4.6};
// Beyond the edge of the field of view too: an area may lie 2 σ from where it is thought to, and
// ceilings are inspected within a few degrees of that edge.
constexpr double kElevations_rad[] = {0.0,    0.12,  -0.12,  0.22,  -0.22, 0.3,    -0.3,
                                      0.37,   -0.37, 0.43,   -0.43, 0.475, -0.475, 0.505,
                                      -0.505, 0.535, -0.535, 0.565, -0.565};
constexpr int kAzimuths = 24;
constexpr int kRound = 8;  // attempts
constexpr double kGolden = 0.618034, kSilver = 0.414214, kBetween_rad = 0.12;
constexpr double kBeside_m = 0.01;
constexpr double kAside_m = 0.42;  // still within the rule's distance of where it was sighted
constexpr double kTurn_rad = 0.8;
constexpr int kPushes = 12;
constexpr std::size_t kLinesOfSight = 400;  // asked for at most, until looks have been in vain

double angle(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }

/// Chance that nothing hides the area from `p`, by the map: 0 when something does.
double clear(const robot::Knowledge& k, const Vec3& area, const Vec3& n, const Vec3& p) {
  const Vec3 from = (p - area).normalized();
  const auto up_to = [&](const Vec3& q) { return k.map().line_of_sight(p, q, false); };
  if (up_to(area + kGap_m * from) || (n.dot(from) > 0 && up_to(area + kGap_m * n))) return 1;
  return up_to(area + kSlantGap_m * from) ? kSlantClear : 0;
}

}  // namespace

std::optional<ViewPose> view_pose(robot::Knowledge& k, const mission::Area& area,
                                  const std::vector<VainLook>& in_vain, int attempts) {
  SurfaceBelief belief(k.map(), area, k.mission().inspect, k.config().vehicle);
  for (const VainLook& v : in_vain) {
    if (v.refused) belief.refuse(v.look);
  }
  const Vec3 n = belief.normal();
  const double least = kLeastChance[std::clamp(attempts / 2, 0, 3)];

  const Vec3 sighted = area.sighted_from.p - area.position;
  const double sighted_m = sighted.norm();
  const bool refused =
      std::any_of(in_vain.begin(), in_vain.end(), [](const VainLook& v) { return v.refused; });
  const auto open = [&](const Vec3& from) {
    if (!refused) return 1.0;
    const double off = angle(from, sighted / sighted_m) / kOpenBeside_rad;
    return std::max(kOpenAnywhere, std::exp(-off * off));
  };

  struct Candidate {
    double way_s, cost_s;
    ViewPose view;
  };
  const auto cost_s = [](double way_s, double chance) {
    return way_s + kRefusal_s * (1 - chance) / chance;
  };
  std::vector<Candidate> found;
  const auto consider = [&](const Vec3& from, std::span<const double> ranges_m, bool seen) {
    double faces = belief.faces(from);
    for (const VainLook& v : in_vain) {
      const double off = angle(from, v.look.from) / kSameLook_rad;
      faces *= 1 - (v.refused ? kSameLook : kSameLook / 2) * std::exp(-off * off);
    }
    const double beside = open(from);
    faces *= beside;
    if (faces < least) return;
    for (const double range_m : ranges_m) {
      const double chance = faces * belief.in_view(from, range_m);
      const Vec3 p = area.position + range_m * from;
      if (chance < least || !k.map().traversable(p) || !k.paths().reached(p)) continue;
      const bool again = std::any_of(in_vain.begin(), in_vain.end(), [&](const VainLook& v) {
        return v.refused && angle(from, v.look.from) < kSamePose_rad &&
               std::abs(range_m - v.look.range_m) < kSamePose_m;
      });
      if (again) continue;
      const double way_s = nav::travel_time_s(k.paths().flood_distance(p), k.limits());
      const ViewPose view{
          {p, std::atan2(-from.y(), -from.x())}, {from, range_m, beside}, chance, seen};
      found.push_back({way_s, cost_s(way_s, chance), view});
    }
  };
  // Directions between those of the rounds before, again and again: some cones are narrower than
  // any grid.
  const int round = attempts / kRound;
  const double az_shift = std::fmod(kGolden * round, 1), el_shift = std::fmod(kSilver * round, 1);
  for (int i = 0; i < kAzimuths; ++i) {
    const double az = 2 * std::numbers::pi * (i + az_shift) / kAzimuths;
    for (const double level : kElevations_rad) {
      const double el = level + (el_shift > 0.5 ? el_shift - 1 : el_shift) * kBetween_rad;
      consider({std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), std::sin(el)}, kRanges_m,
               false);
    }
  }
  // It was in sight from where it was sighted, whatever the voxels say.
  const double on_the_ray_m[] = {0.4 * sighted_m, 0.55 * sighted_m, 0.7 * sighted_m,
                                 0.85 * sighted_m, sighted_m};
  if (sighted_m > 0.5) consider(sighted / sighted_m, on_the_ray_m, true);
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.cost_s < b.cost_s; });
  if (in_vain.empty()) found.resize(std::min(found.size(), kLinesOfSight));
  const Candidate* best = nullptr;
  double best_s = std::numeric_limits<double>::infinity();
  for (Candidate& c : found) {
    if (c.cost_s >= best_s) break;
    const double by_map = c.view.seen ? 1 : clear(k, area.position, n, c.view.pose.p);
    c.view.look.clear *= by_map;
    c.view.probability *= by_map;
    if (c.view.probability < least) continue;
    const double s = cost_s(c.way_s, c.view.probability);
    if (s < best_s) best_s = s, best = &c;
  }
  return best ? std::optional(best->view) : std::nullopt;
}

namespace {

/// The known feature nearest to `p`; nullopt: none is known.
std::optional<Vec3> nearest_known(const robot::Knowledge& k, const Vec3& p) {
  std::optional<Vec3> nearest;
  double least_m = std::numeric_limits<double>::infinity();
  for (const auto& [ref, result] : k.results()) {
    for (const mission::Finding& f : result.inspection.findings) {
      const double m = (f.position - p).norm();
      if (m < least_m) nearest = f.position, least_m = m;
    }
  }
  return nearest;
}

}  // namespace

bool known_near(const robot::Knowledge& k, const Vec3& spot) {
  const std::optional<Vec3> nearest = nearest_known(k, spot);
  return nearest && (*nearest - spot).norm() < k.mission().inspect.match_m + kBeside_m;
}

namespace {

/// Pushed away from the known features, which moves it least, and never against `up`, again and
/// again until none is near; nullopt: that takes too much.
std::optional<Vec3> aside(const robot::Knowledge& k, const Vec3& from, const Vec3& up) {
  const double least_m = k.mission().inspect.match_m + 2 * kBeside_m;
  Vec3 spot = from;
  for (int i = 0; i < kPushes && known_near(k, spot); ++i) {
    for (const auto& [ref, result] : k.results()) {
      for (const mission::Finding& f : result.inspection.findings) {
        const Vec3 away = spot - f.position;
        if (away.norm() >= least_m) continue;
        const Vec3 out = away.norm() > kBeside_m ? Vec3(away.normalized()) : up;
        spot = f.position + least_m * out;
        spot += std::max(0.0, (from - spot).dot(up)) * up;
      }
    }
  }
  if ((spot - from).norm() > kAside_m || known_near(k, spot)) return std::nullopt;
  return spot;
}

/// The area's place, turned in its surface around the known feature `center`.
Vec3 turned(const mission::Area& area, const Vec3& center, double by_rad) {
  const Vec3 axis = area.normal.norm() > 0.5 ? area.normal.normalized() : Vec3(Vec3::UnitZ());
  return center + Eigen::AngleAxisd(by_rad, axis) * (area.position - center);
}

/// Free, or a voxel below the surface: what lies deeper a camera does not see, and refuses.
bool open_to_view(const map::VoxelMap& map, const Vec3& spot) {
  const map::VoxelKey k = map.key(spot);
  if (map.at(k) == map::Voxel::kFree) return true;
  return std::ranges::any_of(map::kFaces, [&](const map::VoxelKey& d) {
    return map.at(map::VoxelKey{k.x + d.x, k.y + d.y, k.z + d.z}) == map::Voxel::kFree;
  });
}

}  // namespace

Vec3 spot_to_ask(const robot::Knowledge& k, const mission::Area& area, int attempt) {
  if (!known_near(k, area.position)) return area.position;
  if (attempt % 3 != 0) {
    const double by_rad = attempt % 3 == 1 ? kTurn_rad : -kTurn_rad;
    const Vec3 center = nearest_known(k, area.position).value_or(area.position);
    const std::optional<Vec3> spot = aside(k, turned(area, center, by_rad), Vec3::Zero());
    if (spot && (*spot - area.position).norm() < kAside_m && open_to_view(k.map(), *spot))
      return *spot;
  }
  const Vec3 squarest = (area.sighted_from.p - area.position).normalized();
  std::optional<Vec3> hidden;
  for (const Vec3& up : {Vec3(Vec3::Zero()), area.normal, squarest, Vec3(Vec3::UnitZ())}) {
    const std::optional<Vec3> spot = aside(k, area.position, up);
    if (!spot) continue;
    if (open_to_view(k.map(), *spot)) return *spot;
    if (!hidden) hidden = spot;
  }
  return hidden.value_or(area.position);
}

bool in_sight(const robot::Knowledge& k, const mission::Area& area, const Pose& pose) {
  const Vec3 from = (pose.p - area.position).normalized();
  const Vec3 edge = area.position + kSlantGap_m * from;
  return k.map().line_of_sight(pose.p, edge, true);
}

}  // namespace muster::agent
