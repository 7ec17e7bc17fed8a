#include "common/map/block_codec.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "common/core/error.h"
#include "common/core/random.h"
#include "tests/unit/map/said.h"

using namespace muster;
using namespace muster::map;

namespace {

bool same(const SaidBlock& a, const SaidBlock& b) {
  return a.key == b.key && a.said.free == b.said.free && a.said.occupied == b.said.occupied;
}

bool survive(const std::vector<SaidBlock>& blocks) {
  const std::vector<SaidBlock> read = decode_blocks(encode_blocks(blocks));
  return std::ranges::equal(blocks, read, same);
}

SaidBlock noise(Random& random, BlockKey key, std::uint64_t states) {
  std::vector<Voxel> voxels;
  for (int i = 0; i < kBlockVoxels; ++i) voxels.push_back(static_cast<Voxel>(random.below(states)));
  return said(key, voxels);
}

/// A floor seen from above, as far as a wall.
SaidBlock room(BlockKey key) {
  std::vector<Voxel> voxels;
  for (int i = 0; i < kBlockVoxels; ++i) {
    const int x = i & 15, z = i >> 8;
    const bool seen = x <= 12 && z >= 3, surface = x == 12 || z == 3;
    voxels.push_back(!seen ? Voxel::kUnknown : surface ? Voxel::kOccupied : Voxel::kFree);
  }
  return said(key, voxels);
}

}  // namespace

TEST_CASE("words on blocks survive the wire") {
  Random random(2, RobotId{1}, "blocks");
  CHECK(survive({}));
  CHECK(survive({said({0, 0, 0}, Voxel::kUnknown), said({0, 0, 1}, Voxel::kFree)}));
  CHECK(survive({noise(random, {-3, 7, 1048575}, 3), noise(random, {1048575, -1048575, 0}, 2)}));
  std::vector<SaidBlock> many;
  for (int i = 0; i < 256; ++i) {
    const auto place = [&] { return static_cast<int>(random.below(2'000'000)) - 1'000'000; };
    many.push_back(noise(random, {place(), place(), place()}, i % 16 == 0 ? 3 : 1));
  }
  CHECK(survive(many));
}

TEST_CASE("what is regular costs little, and what was not said next to nothing") {
  CHECK(encode_blocks(std::array{said({4, 2, 0}, Voxel::kFree)}).size() < 40);
  CHECK(encode_blocks(std::array{room({4, 2, 0})}).size() < 90);
  std::vector<SaidBlock> rooms;
  for (int i = 0; i < 32; ++i) rooms.push_back(room({i, 2, 0}));
  CHECK(encode_blocks(rooms).size() < 32 * 12);
}

TEST_CASE("damaged, cut and lengthened codes are refused or read, and never more") {
  Random random(3, RobotId{1}, "damage");
  const Bytes good = encode_blocks(std::array{noise(random, {1, 2, 3}, 3), room({1, 3, 3})});
  CHECK_THROWS_AS(decode_blocks({}), BadInput);
  for (std::size_t n = 0; n < good.size(); ++n) {
    CHECK_THROWS_AS(decode_blocks(ByteView(good).first(n)), BadInput);
  }
  Bytes longer = good;
  longer.push_back(0);
  CHECK_THROWS_AS(decode_blocks(longer), BadInput);
  int read = 0, refused = 0;
  for (int i = 0; i < 2000; ++i) {
    Bytes bad = good;
    for (int n = 0; n < 3; ++n)
      bad[random.below(bad.size())] ^= static_cast<std::uint8_t>(1 + random.below(255));
    try {
      read += decode_blocks(bad).size() <= 256;
    } catch (const BadInput&) {
      ++refused;
    }
  }
  CHECK(read + refused == 2000);
  CHECK(refused > 100);
}
