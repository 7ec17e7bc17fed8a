#include "common/map/block_codec.h"

#include <zstd.h>

#include <memory>

#include "common/core/error.h"

namespace muster::map {
namespace {
constexpr std::size_t kVoxels = std::size_t{kBlockSide} * kBlockSide * kBlockSide;
constexpr std::size_t kPackedBytes = kVoxels / 4;
constexpr int kLevel = 3;

// A context costs more than a block, so each thread keeps one.
struct Free {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

ZSTD_DCtx* decoder() {
  thread_local const std::unique_ptr<ZSTD_DCtx, Free> context(ZSTD_createDCtx());
  MUSTER_CHECK(context != nullptr);
  return context.get();
}

ZSTD_CCtx* encoder() {
  thread_local const std::unique_ptr<ZSTD_CCtx, Free> context(ZSTD_createCCtx());
  MUSTER_CHECK(context != nullptr);
  return context.get();
}

/// The even bits of a word, close together.
std::uint64_t even_bits(std::uint64_t w) {
  w &= 0x5555555555555555u;
  w = (w | w >> 1) & 0x3333333333333333u;
  w = (w | w >> 2) & 0x0F0F0F0F0F0F0F0Fu;
  w = (w | w >> 4) & 0x00FF00FF00FF00FFu;
  w = (w | w >> 8) & 0x0000FFFF0000FFFFu;
  return (w | w >> 16) & 0x00000000FFFFFFFFu;
}
}  // namespace

Bytes encode_block(std::span<const Voxel> voxels) {
  MUSTER_CHECK(voxels.size() == kVoxels);
  std::uint8_t packed[kPackedBytes] = {};
  for (std::size_t i = 0; i < kVoxels; ++i) {
    packed[i / 4] =
        static_cast<std::uint8_t>(packed[i / 4] | static_cast<unsigned>(voxels[i]) << (i % 4 * 2));
  }
  Bytes bytes(ZSTD_compressBound(kPackedBytes));
  const std::size_t size =
      ZSTD_compressCCtx(encoder(), bytes.data(), bytes.size(), packed, kPackedBytes, kLevel);
  MUSTER_CHECK(!ZSTD_isError(size));
  bytes.resize(size);
  return bytes;
}

States decode_states(ByteView zstd_2bit) {
  std::uint8_t packed[kPackedBytes];
  // A frame that is cut short, damaged or of another size fails here; nothing is ever allocated for
  // what it claims to hold.
  const std::size_t size =
      ZSTD_decompressDCtx(decoder(), packed, kPackedBytes, zstd_2bit.data(), zstd_2bit.size());
  if (ZSTD_isError(size) || size != kPackedBytes) {
    throw BadInput("map block: voxels: not 1024 bytes of zstd data");
  }
  States states;
  for (std::size_t half = 0; half < 2 * states.free.size(); ++half) {  // 32 voxels at a time
    std::uint64_t pairs = 0;
    for (std::size_t i = 0; i < 8; ++i) pairs |= std::uint64_t{packed[8 * half + i]} << (8 * i);
    if ((pairs & pairs >> 1 & 0x5555555555555555u) != 0)
      throw BadInput("map block: voxels: a state must be 0, 1 or 2, not 3");
    states.free[half / 2] |= even_bits(pairs) << (half % 2 * 32);
    states.occupied[half / 2] |= even_bits(pairs >> 1) << (half % 2 * 32);
  }
  return states;
}

std::vector<Voxel> decode_block(ByteView zstd_2bit) {
  const States states = decode_states(zstd_2bit);
  std::vector<Voxel> voxels(kVoxels, Voxel::kUnknown);
  for (int i = 0; i < kBlockVoxels; ++i) {
    if (bit(states.free, i)) voxels[static_cast<std::size_t>(i)] = Voxel::kFree;
    if (bit(states.occupied, i)) voxels[static_cast<std::size_t>(i)] = Voxel::kOccupied;
  }
  return voxels;
}

}  // namespace muster::map
