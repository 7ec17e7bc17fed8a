#include "agent/strategy/view_poses.h"

#include <algorithm>
#include <cmath>

namespace muster::agent {
namespace {

/// Margins within the rule: generous at first, because area and normal are estimates; thin at last,
/// because some features can only just be seen.
constexpr double kMargin_rad[] = {0.25, 0.15, 0.08, 0.03};
constexpr double kGap_m = 0.3;  // the line of sight is asked for up to this far before the surface,
                                // whose voxels are occupied

Vec3 outward(const mission::Area& area, int attempt) {
  const Vec3 to_sighter = (area.sighted_from.p - area.position).normalized();
  Vec3 n = area.normal.norm() > 0.5 ? area.normal : to_sighter;
  if (n.dot(to_sighter) < 0) n = -n;
  if (attempt % 2 == 1) n = to_sighter;  // where it was seen from, it can be seen from
  return n;
}

}  // namespace

std::vector<Pose> view_poses(robot::Knowledge& k, const mission::Area& area, int attempt) {
  const mission::Vehicle& vehicle = k.config().vehicle;
  const double margin = kMargin_rad[std::clamp(attempt, 0, 3)];
  const double max_elevation = vehicle.camera.vfov_rad / 2 - margin / 2;
  const double max_incidence = k.mission().inspect.max_incidence_rad - margin;
  const double max_range_m = std::min(k.mission().inspect.range_m, vehicle.camera.range_m) - 0.6;
  const Vec3 n = outward(area, attempt);
  const double az0 = std::atan2(n.y(), n.x());
  const Vec3 edge = area.position + kGap_m * n;

  std::vector<std::pair<double, Pose>> found;
  const auto consider = [&](const Vec3& p) {
    const Vec3 d = area.position - p;
    const double range = d.norm(), flat = d.head<2>().norm();
    if (range > max_range_m || flat < 0.3) return;
    if (std::abs(std::atan2(d.z(), flat) - vehicle.pitch_rad) > max_elevation) return;
    const double incidence = std::acos(std::clamp(-d.dot(n) / range, -1.0, 1.0));
    if (incidence > max_incidence || !k.map().traversable(p) || !k.paths().reached(p)) return;
    if (!k.map().line_of_sight(p, edge, false)) return;
    found.push_back({k.paths().flood_distance(p) + 1.5 * incidence, {p, std::atan2(d.y(), d.x())}});
  };
  for (const double range : {1.4, 2.0, 2.8, 3.6}) {
    for (int i = 0; i < 16; ++i) {
      const double az = az0 + (i % 2 == 0 ? 1 : -1) * ((i + 1) / 2) * 0.2 + 0.07 * attempt;
      for (const double el : {0.0, 0.25, -0.25, 0.45, -0.45}) {
        consider(area.position + range * Vec3(std::cos(el) * std::cos(az),
                                              std::cos(el) * std::sin(az), std::sin(el)));
      }
    }
  }
  const Vec3 d = area.position - area.sighted_from.p;
  if (found.empty() && k.map().traversable(area.sighted_from.p) &&
      k.paths().reached(area.sighted_from.p)) {
    found.push_back({k.paths().flood_distance(area.sighted_from.p),
                     {area.sighted_from.p, std::atan2(d.y(), d.x())}});
  }
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Pose> poses;
  for (const auto& [cost, pose] : found) {
    const bool apart = std::all_of(poses.begin(), poses.end(),
                                   [&](const Pose& q) { return (q.p - pose.p).norm() > 0.6; });
    if (apart) poses.push_back(pose);
    if (poses.size() == 4) break;
  }
  return poses;
}

}  // namespace muster::agent
