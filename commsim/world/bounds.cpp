#include "commsim/world/bounds.h"

#include <algorithm>
#include <limits>

namespace muster::world {
namespace {

/// Features that cannot share one inspection: any two are farther apart than one area reaches.
/// Every set of them is a bound.
std::size_t separate_looks(const std::vector<Feature>& features, double match_m) {
  std::vector<Vec3> chosen;
  for (const Feature& f : features) {
    const bool apart = std::all_of(chosen.begin(), chosen.end(), [&](const Vec3& c) {
      return (c - f.position).norm() > 2 * match_m;
    });
    if (apart) chosen.push_back(f.position);
  }
  return chosen.size();
}

/// Prim: the cheapest way to hang every feature on some start, where getting from one to the next
/// is only as far as their viewing spheres are apart.
double spanning_forest_m(const std::vector<Vec3>& starts, const std::vector<Feature>& features,
                         double range_m) {
  std::vector<double> cost(features.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < features.size(); ++i) {
    for (const Vec3& s : starts) {
      cost[i] = std::min(cost[i], std::max(0.0, (features[i].position - s).norm() - range_m));
    }
  }
  std::vector<char> hung(features.size());
  double total = 0;
  for (std::size_t n = 0; n < features.size(); ++n) {
    std::size_t best = features.size();
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (!hung[i] && (best == features.size() || cost[i] < cost[best])) best = i;
    }
    hung[best] = 1;
    total += cost[best];
    for (std::size_t i = 0; i < features.size(); ++i) {
      const double gap = (features[i].position - features[best].position).norm() - 2 * range_m;
      cost[i] = std::min(cost[i], std::max(0.0, gap));
    }
  }
  return total;
}

}  // namespace

double lower_bound_s(const mission::Mission& mission, const std::vector<Feature>& features) {
  std::vector<Vec3> starts;
  double speed = 0;
  for (const mission::RobotConfig& r : mission.fleet) {
    if (r.role != mission::Role::kInspector) continue;
    starts.push_back(r.start.p);
    speed = std::max(speed, r.vehicle.speed_mps);
  }
  if (starts.empty() || features.empty() || speed <= 0) return 0;
  const double range = mission.inspect.range_m, hold = mission.inspect.hold_s;
  double reach = 0;
  for (const Feature& f : features) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& s : starts) nearest = std::min(nearest, (f.position - s).norm());
    reach = std::max(reach, std::max(0.0, nearest - range) / speed + hold);
  }
  // Several areas may be looked at together under `inspect: shared`, so only the way counts there.
  const double looks =
      mission.inspect.shared
          ? 0
          : static_cast<double>(separate_looks(features, mission.inspect.match_m)) * hold;
  const double way = spanning_forest_m(starts, features, range) / speed;
  return std::max(reach, (way + looks) / static_cast<double>(starts.size()));
}

}  // namespace muster::world
