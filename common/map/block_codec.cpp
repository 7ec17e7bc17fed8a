#include <zstd.h>

#include "common/core/error.h"
#include "common/map/voxel_map.h"

namespace muster::map {
namespace {
constexpr std::size_t kVoxels = std::size_t{kBlockSide} * kBlockSide * kBlockSide;
constexpr std::size_t kPackedBytes = kVoxels / 4;
constexpr int kLevel = 3;
}  // namespace

Bytes encode_block(std::span<const Voxel> voxels) {
  MUSTER_CHECK(voxels.size() == kVoxels);
  std::uint8_t packed[kPackedBytes] = {};
  for (std::size_t i = 0; i < kVoxels; ++i) {
    packed[i / 4] =
        static_cast<std::uint8_t>(packed[i / 4] | static_cast<unsigned>(voxels[i]) << (i % 4 * 2));
  }
  Bytes bytes(ZSTD_compressBound(kPackedBytes));
  const std::size_t size = ZSTD_compress(bytes.data(), bytes.size(), packed, kPackedBytes, kLevel);
  MUSTER_CHECK(!ZSTD_isError(size));
  bytes.resize(size);
  return bytes;
}

std::vector<Voxel> decode_block(ByteView zstd_2bit) {
  std::uint8_t packed[kPackedBytes];
  // A frame that is cut short, damaged or of another size fails here; nothing is ever allocated for
  // what it claims to hold.
  const std::size_t size =
      ZSTD_decompress(packed, kPackedBytes, zstd_2bit.data(), zstd_2bit.size());
  if (ZSTD_isError(size) || size != kPackedBytes) {
    throw BadInput("map block: voxels: not 1024 bytes of zstd data");
  }
  std::vector<Voxel> voxels(kVoxels);
  for (std::size_t i = 0; i < kVoxels; ++i) {
    const unsigned state = packed[i / 4] >> (i % 4 * 2) & 3u;
    if (state == 3) throw BadInput("map block: voxels: a state must be 0, 1 or 2, not 3");
    voxels[i] = static_cast<Voxel>(state);
  }
  return voxels;
}

}  // namespace muster::map
