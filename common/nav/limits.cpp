#include "common/nav/limits.h"

#include <cmath>

namespace muster::nav {

double travel_time_s(double d_m, const Limits& limits) {
  if (!(d_m > 0)) return 0;
  const double v = limits.speed_mps, a = limits.accel_mps2;
  return d_m <= v * v / a ? 2 * std::sqrt(d_m / a) : d_m / v + v / a;
}

}  // namespace muster::nav
