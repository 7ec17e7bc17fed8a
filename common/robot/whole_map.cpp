#include "common/robot/whole_map.h"

#include <zstd.h>

#include <array>
#include <tuple>

#include "common/core/bytes.h"
#include "common/core/error.h"
#include "common/map/block.h"

namespace muster::robot {
namespace {

constexpr std::size_t kWords = std::tuple_size_v<map::Plane>;
constexpr int kLevel = 3;                // of zstd
constexpr int kPieceShift = 2;           // 4³ blocks
constexpr std::uint64_t kNodeBytes = 2;  // two bits for each of its eight children
constexpr int kLevelsAbove = 12;         // of the 16 levels of an OcTree, blocks take 4

void append(Bytes& bytes, const void* data, std::size_t size) {
  const auto* first = static_cast<const std::uint8_t*>(data);
  bytes.insert(bytes.end(), first, first + size);
}

/// The inner nodes of a pruned octree over a block: those whose children differ.
std::uint64_t inner_nodes(const map::BlockView& block) {
  constexpr std::uint8_t kMixed = 3;
  std::array<std::uint8_t, map::kBlockVoxels> state;
  for (int i = 0; i < map::kBlockVoxels; ++i) {
    state[static_cast<std::size_t>(i)] = map::bit(block.occupied, i) ? 2
                                         : map::bit(block.free, i)   ? 1
                                                                     : 0;
  }
  std::uint64_t nodes = 0;
  for (int side = map::kBlockSide / 2; side > 0; side /= 2) {
    const auto child = [&](int x, int y, int z) {
      const int at = x + 2 * side * (y + 2 * side * z);
      return state[static_cast<std::size_t>(at)];
    };
    for (int i = 0; i < side * side * side; ++i) {  // in place: children are read before
      const int x = i % side * 2, y = i / side % side * 2, z = i / (side * side) * 2;
      std::uint8_t node = child(x, y, z);
      for (int c = 1; c < 8; ++c) {
        if (child(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)) != node) node = kMixed;
      }
      nodes += node == kMixed ? 1 : 0;
      state[static_cast<std::size_t>(i)] = node;
    }
  }
  return nodes;
}

}  // namespace

void WholeMap::measure_octree(const map::BlockKey& key, const map::BlockView& block) {
  const auto [at, fresh] = inner_.try_emplace(key, 0);
  const std::uint64_t nodes = inner_nodes(block);
  sum_.octree += kNodeBytes * nodes - kNodeBytes * at->second;
  at->second = nodes;
  for (int level = 1; fresh && level <= kLevelsAbove; ++level) {
    const map::BlockKey node{key.x >> level, key.y >> level, key.z >> level};
    if (!above_.emplace(level, node).second) break;
    sum_.octree += kNodeBytes;
  }
}

void WholeMap::measure_piece(const map::VoxelMap& map, Piece& piece) {
  Bytes plain;
  for (const map::BlockKey& key : piece.blocks) {
    const map::BlockView block = map.view(key);
    append(plain, &key, sizeof key);
    append(plain, block.free, kWords * sizeof *block.free);
    append(plain, block.occupied, kWords * sizeof *block.occupied);
  }
  Bytes packed(ZSTD_compressBound(plain.size()));
  const std::size_t size =
      ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), kLevel);
  MUSTER_CHECK(!ZSTD_isError(size));
  sum_.packed += size - piece.bytes;
  piece.bytes = size;
}

mission::WholeMapBytes WholeMap::bytes(const map::VoxelMap& map) {
  std::set<map::BlockKey> changed;
  for (const map::BlockKey& key : map.changes(cursor_)) {
    const map::BlockView block = map.view(key);
    if (!block) continue;
    measure_octree(key, block);
    const map::BlockKey piece{key.x >> kPieceShift, key.y >> kPieceShift, key.z >> kPieceShift};
    pieces_[piece].blocks.insert(key);
    changed.insert(piece);
  }
  for (const map::BlockKey& key : changed) measure_piece(map, pieces_[key]);
  return sum_;
}

}  // namespace muster::robot
