#include "common/robot/whole_map.h"

#include <zstd.h>

#include "common/core/error.h"

namespace muster::robot {
namespace {

constexpr std::size_t kWords = 64;  // per plane of a block
constexpr int kLevel = 3;

void append(Bytes& bytes, const void* data, std::size_t size) {
  const auto* first = static_cast<const std::uint8_t*>(data);
  bytes.insert(bytes.end(), first, first + size);
}

}  // namespace

Bytes whole_map(const map::VoxelMap& map) {
  Bytes plain;
  std::uint64_t from_the_start = 0;
  for (const map::BlockKey& key : map.changes(from_the_start)) {
    const map::BlockView block = map.view(key);
    if (!block) continue;
    append(plain, &key, sizeof key);
    append(plain, block.free, kWords * sizeof *block.free);
    append(plain, block.occupied, kWords * sizeof *block.occupied);
  }
  Bytes packed(ZSTD_compressBound(plain.size()));
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), kLevel);
  MUSTER_CHECK(!ZSTD_isError(size));
  packed.resize(size);
  return packed;
}

}  // namespace muster::robot
