#include "commsim/walls.h"

#include <algorithm>

namespace muster::commsim {
namespace {

constexpr double kEndTolerance_m = 0.01;
constexpr double kPast_m = 1e-3;   // a ray goes on so far behind what it met
constexpr int kMostSurfaces = 64;  // no radio gets through half as many walls

}  // namespace

int walls_between(const world::Scene& scene, const Vec3& a, const Vec3& b) {
  const Vec3 way = b - a;
  const double length_m = way.norm(), end_m = length_m - kEndTolerance_m;
  const Vec3 direction = way / length_m;
  int entered = 0, left = 0;
  double at_m = kEndTolerance_m;
  while (at_m < end_m && entered + left < kMostSurfaces) {
    const auto hit = scene.cast(a + at_m * direction, direction, end_m - at_m);
    if (!hit) break;
    ++(hit->from_behind ? left : entered);
    at_m += hit->distance_m + kPast_m;
  }
  return std::max(entered, left);
}

}  // namespace muster::commsim
