#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

namespace muster {

using Vec3 = Eigen::Vector3d;  ///< metres, world frame ENU, z up

/// Position and heading of a vehicle that flies level. Yaw from +x towards +y, in (−π, π].
struct Pose {
  Vec3 p = Vec3::Zero();
  double yaw_rad = 0;
};

inline double wrap_angle(double a) {
  a = std::remainder(a, 2 * std::numbers::pi);
  return a <= -std::numbers::pi ? a + 2 * std::numbers::pi : a;
}

}  // namespace muster
