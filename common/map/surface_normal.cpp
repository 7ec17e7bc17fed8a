#include <Eigen/Eigenvalues>

#include "common/map/targets.h"

namespace muster::map {

Vec3 surface_normal(const VoxelMap& map, const Vec3& p, const Vec3& seen_from) {
  constexpr int kReach = 3;
  constexpr int kLeast = 4;
  const VoxelKey k = map.key(p);
  std::vector<Vec3> occupied;
  Vec3 open = Vec3::Zero();  // from matter towards free space
  for (int z = -kReach; z <= kReach; ++z) {
    for (int y = -kReach; y <= kReach; ++y) {
      for (int x = -kReach; x <= kReach; ++x) {
        const Vec3 d(x, y, z);
        if (d.squaredNorm() > kReach * kReach + 0.5) continue;
        const Voxel v = map.at(VoxelKey{k.x + x, k.y + y, k.z + z});
        if (v == Voxel::kOccupied) occupied.push_back(d);
        if (v == Voxel::kFree) open += d;
        if (v == Voxel::kOccupied) open -= d;
      }
    }
  }
  if (occupied.size() < kLeast) return Vec3::Zero();
  Vec3 mean = Vec3::Zero();
  for (const Vec3& d : occupied) mean += d / static_cast<double>(occupied.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& d : occupied) spread += (d - mean) * (d - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  // A sheet has a thinnest direction; at corners and lumps free space tells better.
  const bool sheet = axes.eigenvalues()[0] < 0.35 * axes.eigenvalues()[1];
  Vec3 normal = sheet ? Vec3(axes.eigenvectors().col(0)) : open;
  if (normal.norm() < 1e-9) return Vec3::Zero();
  normal.normalize();
  return normal.dot(seen_from - p) < 0 ? Vec3(-normal) : normal;
}

}  // namespace muster::map
