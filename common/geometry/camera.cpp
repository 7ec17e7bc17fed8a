#include "common/geometry/camera.h"

namespace muster {

bool FieldOfView::contains(const Pose& sensor, double pitch_rad, const Vec3& p) const {
  const Vec3 d = p - sensor.p;
  if (d.squaredNorm() > range_m * range_m) return false;
  // Into the sensor frame: undo yaw, then pitch (x forward, y left, z up).
  const double cy = std::cos(sensor.yaw_rad), sy = std::sin(sensor.yaw_rad);
  const double x0 = cy * d.x() + sy * d.y(), y = -sy * d.x() + cy * d.y();
  const double cp = std::cos(pitch_rad), sp = std::sin(pitch_rad);
  const double x = cp * x0 + sp * d.z(), z = -sp * x0 + cp * d.z();
  const double az = std::atan2(y, x), el = std::atan2(z, std::hypot(x, y));
  return std::abs(az) <= hfov_rad / 2 + 1e-9 && std::abs(el) <= vfov_rad / 2 + 1e-9;
}

Vec3 ray_direction(double yaw_rad, double pitch_rad, double az_rad, double el_rad) {
  const Vec3 s(std::cos(el_rad) * std::cos(az_rad), std::cos(el_rad) * std::sin(az_rad),
               std::sin(el_rad));
  const double cp = std::cos(pitch_rad), sp = std::sin(pitch_rad);
  const Vec3 level(cp * s.x() - sp * s.z(), s.y(), sp * s.x() + cp * s.z());
  const double cy = std::cos(yaw_rad), sy = std::sin(yaw_rad);
  return {cy * level.x() - sy * level.y(), sy * level.x() + cy * level.y(), level.z()};
}

}  // namespace muster
