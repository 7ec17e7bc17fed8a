#pragma once

#include "common/geometry/pose.h"

namespace muster {

/// What a sensor can see: a pyramid (camera) around its optical axis, or a full turn (hfov 2π, a 2D
/// lidar has vfov 0).
struct FieldOfView {
  double hfov_rad = std::numbers::pi / 2;
  double vfov_rad = std::numbers::pi / 3;
  double range_m = 5;

  /// Is `p` inside the field of view and range of a level sensor at `sensor`, pitched up by
  /// `pitch_rad`? Says nothing of occlusion.
  bool contains(const Pose& sensor, double pitch_rad, const Vec3& p) const;
};

/// Unit direction, in the world frame, of the ray at azimuth `az_rad` (left positive) and elevation
/// `el_rad` of a sensor with the given yaw and pitch. Cameras use a pinhole-like grid of equal
/// angles.
Vec3 ray_direction(double yaw_rad, double pitch_rad, double az_rad, double el_rad);

}  // namespace muster
