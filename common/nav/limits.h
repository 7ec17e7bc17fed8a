#pragma once

#include <numbers>

namespace muster::nav {

/// What a body can do. The defaults are RULES.md's.
struct Limits {
  double speed_mps = 2;
  double accel_mps2 = 2;
  double yaw_rate_radps = 1.5;
  bool ground = false;
};

/// Time from rest to rest over a straight `d_m`: 2√(d/a) for d ≤ v²/a, else d/v + v/a (FIELD-NOTES
/// 2).
double travel_time_s(double d_m, const Limits& limits);

}  // namespace muster::nav
