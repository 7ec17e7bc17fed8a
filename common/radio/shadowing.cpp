#include "common/radio/shadowing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "common/core/random.h"

namespace muster::radio {
namespace {

constexpr int kWaves = 48;

}  // namespace

Shadowing::Shadowing(std::uint64_t seed, double distance_m) : distance_m_(distance_m) {
  if (!(distance_m > 0)) {
    throw std::invalid_argument("shadowing_distance_m: a positive number of metres is expected");
  }
  Random random(seed, kNoRobot, "radio shadowing");
  const double scale = std::numbers::sqrt2 / distance_m;
  const auto draw = [&] {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return Vec3(scale * x, scale * y, scale * z);
  };
  for (int i = 0; i < kWaves; ++i) {
    const Vec3 k_near = draw(), k_far = draw();
    waves_.push_back({k_near, k_far, random.uniform(0, 2 * std::numbers::pi)});
  }
}

double Shadowing::between(const Vec3& a, const Vec3& b) const {
  const bool in_order = !std::lexicographical_compare(b.begin(), b.end(), a.begin(), a.end());
  const Vec3 &p = in_order ? a : b, &q = in_order ? b : a;
  double sum = 0;
  for (const Wave& w : waves_) {
    sum += std::cos(w.k_near.dot(p) + w.k_far.dot(q) + w.phase_rad) +
           std::cos(w.k_near.dot(q) + w.k_far.dot(p) + w.phase_rad);
  }
  // Where both ends are close, the wave and its mirror image agree and would add up to more.
  const double r = (a - b).norm() / distance_m_;
  return sum / std::sqrt(kWaves * (1 + std::exp(-2 * r * r)));
}

}  // namespace muster::radio
