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
  const VoxelKey first = voxel_in(b, 0);
  const auto center = [&](int x, int y, int z) -> Vec3 {
    return Vec3(first.x + x + 0.5, first.y + y + 0.5, first.z + z + 0.5) * resolution_m;
  };
  // A box is convex: a row of voxels whose ends are both inside is inside.
  for (int z = 0; z < kBlockSide; ++z) {
    for (int y = 0; y < kBlockSide; ++y) {
      std::uint64_t bits = 0xFFFF;
      if (!box.contains(center(0, y, z), 1e-9) || !box.contains(center(15, y, z), 1e-9)) {
        bits = 0;
        for (int x = 0; x < kBlockSide; ++x)
          bits |= std::uint64_t{box.contains(center(x, y, z), 1e-9)} << x;
      }
      plane[static_cast<std::size_t>(z << 2 | y >> 2)] |= bits << ((y & 3) << 4);
    }
  }
  return plane;
}

}  // namespace muster::map
