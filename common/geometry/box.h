#pragma once

#include <Eigen/Core>
#include <array>

#include "common/geometry/pose.h"

namespace muster {

/// A box that may be turned about z: the bounding boxes of a mission, the site hull, fences.
struct Box {
  Vec3 center = Vec3::Zero();
  Vec3 size = Vec3::Zero();  ///< full edge lengths
  double yaw_rad = 0;

  static Box from_corners(const Vec3& low, const Vec3& high);

  bool contains(const Vec3& p, double margin_m = 0) const;  ///< margin > 0 grows the box
  double distance(const Vec3& p) const;                     ///< 0 inside
  Vec3 closest(const Vec3& p) const;
  double volume() const { return size.prod(); }
  /// The 8 corners; the first four are the lower ones, counter-clockwise.
  std::array<Vec3, 8> corners() const;
  /// Axis-aligned bounds in the world frame.
  Vec3 low() const;
  Vec3 high() const;
};

}  // namespace muster
