#include "common/map/block_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>

#include "common/core/error.h"
#include "common/map/block.h"
#include "common/map/range_coder.h"

namespace muster::map {
namespace {

constexpr std::size_t kAtMost = 256;  // blocks in one code: what a few bytes may ask for is bounded
constexpr int kFar = 1 << 20;         // what `pack` can number
constexpr int kStates = 3;            // not said, free, occupied
constexpr int kNear = 7;              // voxels before this one that its odds depend on

/// The neighbours of a voxel, all coded before it.
constexpr int kBefore[kNear][3] = {{-1, 0, 0},  {0, -1, 0},  {0, 0, -1}, {-1, -1, 0},
                                   {-1, 0, -1}, {0, -1, -1}, {1, -1, 0}};

constexpr std::size_t power(int base, int n) {
  return n == 0 ? 1 : static_cast<std::size_t>(base) * power(base, n - 1);
}

/// The form of a code, written once for both directions: `code(odds, value)` writes the bit
/// `value`, or reads one and returns it.
template <typename Coder>
class Form {
 public:
  explicit Form(Coder& code) : code_(code) {}

  bool more(bool there_is) { return code_(more_, there_is); }

  /// The next block's index, as its distance from the one before.
  void key(BlockKey& k) {
    k.x = last_.x + number(k.x - last_.x, 0);
    k.y = last_.y + number(k.y - last_.y, 1);
    k.z = last_.z + number(k.z - last_.z, 2);
    if (std::max({std::abs(k.x), std::abs(k.y), std::abs(k.z)}) >= kFar) {
      throw BadInput("map block: ix, iy, iz: must be within ±1048575");
    }
    last_ = k;
  }

  void states(States& s) {
    around_.fill(0);
    bool below = false;
    for (int z = 0; z < kBlockSide; ++z) {
      bool said = false;
      for (int y = 0; y < kBlockSide; ++y) said |= (row(s.free, y, z) | row(s.occupied, y, z)) != 0;
      below = code_(layer_[below], said);
      for (int y = 0; below && y < kBlockSide; ++y) line(s, y, z);
    }
  }

 private:
  static constexpr int kWide = kBlockSide + 2;  // a margin spares asking where the block ends
  static constexpr int at(int x, int y, int z) {
    return x + 1 + kWide * (y + 1) + kWide * kWide * (z + 1);
  }
  static std::uint32_t row(const Plane& plane, int y, int z) {
    return map::row(plane.data(), y, z);
  }
  static void put_row(Plane& plane, int y, int z, std::uint32_t bits) {
    const auto word = static_cast<std::size_t>(z << 2 | y >> 2);
    plane[word] |= std::uint64_t{bits} << ((y & 3) << 4);
  }

  void line(States& s, int y, int z) {
    std::uint32_t free = row(s.free, y, z), occupied = row(s.occupied, y, z);
    for (int x = 0; x < kBlockSide; ++x) {
      std::size_t context = 0;
      for (const auto& d : kBefore) {
        context =
            context * kStates + around_[static_cast<std::size_t>(at(x + d[0], y + d[1], z + d[2]))];
      }
      const std::uint32_t mask = 1u << x;
      std::uint8_t state = 0;
      if (code_(said_[context], ((free | occupied) & mask) != 0)) {
        state = code_(occupied_[context], (occupied & mask) != 0) ? 2 : 1;
      }
      around_[static_cast<std::size_t>(at(x, y, z))] = state;
      free |= state == 1 ? mask : 0;
      occupied |= state == 2 ? mask : 0;
    }
    put_row(s.free, y, z, free);
    put_row(s.occupied, y, z, occupied);
  }

  int number(int v, std::size_t axis) {
    const auto folded =
        v < 0 ? 2 * static_cast<std::uint32_t>(-v) - 1 : 2 * static_cast<std::uint32_t>(v);
    const int width = std::bit_width(folded + 1) - 1;
    int n = 0;
    while (n < 22 && code_(width_[axis][static_cast<std::size_t>(n)], n < width)) ++n;
    std::uint32_t value = 1;
    for (int i = n - 1; i >= 0; --i) {
      value = value << 1 |
              (code_(digit_[axis][static_cast<std::size_t>(n)], (folded + 1) >> i & 1) ? 1u : 0u);
    }
    --value;
    return value & 1 ? -static_cast<int>((value + 1) / 2) : static_cast<int>(value / 2);
  }

  Coder& code_;
  BlockKey last_;
  Odds more_;
  std::array<Odds, 2> layer_;
  std::array<std::array<Odds, 23>, 3> width_, digit_;
  std::array<Odds, power(kStates, kNear)> said_, occupied_;
  std::array<std::uint8_t, kWide * kWide*(kBlockSide + 1)> around_{};
};

}  // namespace

Bytes encode_blocks(std::span<const SaidBlock> blocks) {
  MUSTER_CHECK(blocks.size() <= kAtMost);
  RangeEncoder encoder;
  const auto code = [&](Odds& odds, bool one) {
    encoder.bit(odds, one);
    return one;
  };
  Form form(code);
  for (SaidBlock block : blocks) {
    form.more(true);
    form.key(block.key);
    form.states(block.said);
  }
  form.more(false);
  return encoder.finish();
}

std::vector<SaidBlock> decode_blocks(ByteView bytes) {
  RangeDecoder decoder(bytes);
  const auto code = [&](Odds& odds, bool) { return decoder.bit(odds); };
  Form form(code);
  std::vector<SaidBlock> blocks;
  while (form.more(false)) {
    if (blocks.size() == kAtMost) throw BadInput("map block: more than 256 blocks");
    SaidBlock& block = blocks.emplace_back();
    form.key(block.key);
    form.states(block.said);
  }
  if (!decoder.at_end()) throw BadInput("map block: more bytes than its blocks take");
  return blocks;
}

}  // namespace muster::map
