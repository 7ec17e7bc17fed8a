#include "common/geometry/box.h"

namespace muster {
namespace {

Vec3 to_local(const Box& b, const Vec3& p) {
  Vec3 d = p - b.center;
  if (b.yaw_rad == 0) return d;
  const double c = std::cos(b.yaw_rad), s = std::sin(b.yaw_rad);
  return {c * d.x() + s * d.y(), -s * d.x() + c * d.y(), d.z()};
}

Vec3 to_world(const Box& b, const Vec3& q) {
  const double c = std::cos(b.yaw_rad), s = std::sin(b.yaw_rad);
  return b.center + Vec3(c * q.x() - s * q.y(), s * q.x() + c * q.y(), q.z());
}

}  // namespace

Box Box::from_corners(const Vec3& low, const Vec3& high) {
  return {(low + high) / 2, high - low, 0};
}

bool Box::contains(const Vec3& p, double margin_m) const {
  const Vec3 half = size / 2 + Vec3::Constant(margin_m);
  return (to_local(*this, p).cwiseAbs().array() <= half.array()).all();
}

Vec3 Box::closest(const Vec3& p) const {
  return to_world(*this, to_local(*this, p).cwiseMax(-size / 2).cwiseMin(size / 2));
}

double Box::distance(const Vec3& p) const {
  const Vec3 outside = (to_local(*this, p).cwiseAbs() - size / 2).cwiseMax(0.0);
  return outside.norm();
}

std::array<Vec3, 8> Box::corners() const {
  static constexpr double kX[4] = {-1, 1, 1, -1}, kY[4] = {-1, -1, 1, 1};
  std::array<Vec3, 8> result;
  for (std::size_t i = 0; i < 8; ++i) {
    const Vec3 unit(kX[i % 4], kY[i % 4], i < 4 ? -1 : 1);
    result[i] = to_world(*this, unit.cwiseProduct(size) / 2);
  }
  return result;
}

Vec3 Box::low() const {
  Vec3 v = Vec3::Constant(1e300);
  for (const Vec3& c : corners()) v = v.cwiseMin(c);
  return v;
}

Vec3 Box::high() const {
  Vec3 v = Vec3::Constant(-1e300);
  for (const Vec3& c : corners()) v = v.cwiseMax(c);
  return v;
}

}  // namespace muster
