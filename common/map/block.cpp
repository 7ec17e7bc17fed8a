#include "common/map/block.h"

#include <bit>

#include "common/core/error.h"

namespace muster::map {

namespace {
constexpr int kOffset = 1 << 20;
constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
std::uint64_t part(int v) {
  MUSTER_CHECK(v >= -kOffset && v < kOffset);
  const int from_zero = v + kOffset;
  return static_cast<std::uint64_t>(from_zero);
}
int unpart(std::uint64_t v) { return static_cast<int>(v & kMask) - kOffset; }
}  // namespace

std::uint64_t pack(BlockKey b) { return part(b.x) << 42 | part(b.y) << 21 | part(b.z); }
BlockKey unpack_block(std::uint64_t key) {
  return {unpart(key >> 42), unpart(key >> 21), unpart(key)};
}

int count(const Plane& plane) {
  int n = 0;
  for (const std::uint64_t w : plane) n += std::popcount(w);
  return n;
}

Plane voxels_inside(BlockKey b, double resolution_m, const Box& box) {
  Plane plane{};
  const double side = kBlockSide * resolution_m;
  const Vec3 low = Vec3(b.x, b.y, b.z) * side, high = low + Vec3::Constant(side);
  const Vec3 box_low = box.low(), box_high = box.high();
  if ((low.array() > box_high.array()).any() || (high.array() < box_low.array()).any())
    return plane;
  bool all = true;
  for (int i = 0; i < 8 && all; ++i) {
    all = box.contains(
        {i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()});
  }
  if (all) {
    plane.fill(~std::uint64_t{0});
    return plane;
  }
  for (int i = 0; i < kBlockVoxels; ++i) {
    const VoxelKey k = voxel_in(b, i);
    if (box.contains(Vec3(k.x + 0.5, k.y + 0.5, k.z + 0.5) * resolution_m, 1e-9))
      put(plane, i, true);
  }
  return plane;
}

}  // namespace muster::map
