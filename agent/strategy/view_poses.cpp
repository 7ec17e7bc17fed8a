#include "agent/strategy/view_poses.h"

#include <algorithm>
#include <cmath>

namespace muster::agent {
namespace {

/// Margins within the rule: generous at first, because area and normal are estimates; thin at last,
/// because some features can only just be seen.
constexpr double kMargin_rad[] = {0.25, 0.12, 0.03, 0.03};
constexpr double kGap_m = 0.3;  // the line of sight is asked for up to this far before the surface,
                                // whose voxels are occupied
constexpr double kAnotherDirection_rad = 0.6;
constexpr double kRefusedCost_m = 8;    // of a direction close to a refused one
constexpr double kIncidenceCost_m = 4;  // per radian
constexpr std::size_t kPoses = 3;

double angle(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }

}  // namespace

std::vector<Pose> view_poses(robot::Knowledge& k, const mission::Area& area, int attempt,
                             const std::vector<Vec3>& refused_from) {
  const mission::Vehicle& vehicle = k.config().vehicle;
  const double margin = kMargin_rad[std::clamp(attempt, 0, 3)];
  const double max_elevation = vehicle.camera.vfov_rad / 2 - margin / 2;
  // With every refusal the estimate of the normal is trusted less.
  const double max_incidence = k.mission().inspect.max_incidence_rad - margin + 0.35 * attempt;
  const double max_range_m = std::min(k.mission().inspect.range_m, vehicle.camera.range_m) - 0.6;
  const Vec3 n =
      area.normal.norm() > 0.5 ? area.normal : (area.sighted_from.p - area.position).normalized();
  const Vec3 edge = area.position + kGap_m * n;

  struct Candidate {
    double cost;
    Pose pose;
    Vec3 from;  // unit, area → pose
  };
  std::vector<Candidate> found;
  for (const double range : {1.4, 2.0, 2.8, 3.6}) {
    if (range > max_range_m) continue;
    for (int i = 0; i < 24; ++i) {
      const double az = (i + 0.5 * (attempt % 2)) * std::numbers::pi / 12;
      for (const double el : {0.0, 0.22, -0.22, 0.42, -0.42}) {
        if (std::abs(el + vehicle.pitch_rad) > max_elevation) continue;
        const Vec3 from(std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), std::sin(el));
        const double incidence = angle(from, n);
        if (incidence > max_incidence) continue;
        const Vec3 p = area.position + range * from;
        if (!k.map().traversable(p) || !k.map().line_of_sight(p, edge, false) ||
            !k.paths().reached(p))
          continue;
        double cost = k.paths().flood_distance(p) + kIncidenceCost_m * incidence;
        for (const Vec3& refused : refused_from)
          cost += angle(from, refused) < kAnotherDirection_rad ? kRefusedCost_m : 0;
        found.push_back({cost, {p, std::atan2(-from.y(), -from.x())}, from});
      }
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.cost < b.cost; });
  std::vector<Candidate> chosen;
  for (const Candidate& c : found) {
    const bool differs = std::all_of(chosen.begin(), chosen.end(), [&](const Candidate& o) {
      return angle(o.from, c.from) > kAnotherDirection_rad;
    });
    if (differs) chosen.push_back(c);
    if (chosen.size() == kPoses) break;
  }
  std::vector<Pose> poses;
  for (const Candidate& c : chosen) poses.push_back(c.pose);
  return poses;
}

}  // namespace muster::agent
