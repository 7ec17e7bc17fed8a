#include "common/nav/grid.h"

#include <cmath>

namespace muster::nav {
namespace {

std::array<Step, kSteps> make_steps() {
  std::array<Step, kSteps> all;
  const auto number = [](int x, int y, int z) { return (x + 1) + 3 * (y + 1) + 9 * (z + 1); };
  const auto within = [](int part, int whole) { return part == 0 || part == whole; };
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        Step& step = all[static_cast<std::size_t>(number(dx, dy, dz))];
        step.dx = dx, step.dy = dy, step.dz = dz;
        step.axes = std::abs(dx) + std::abs(dy) + std::abs(dz);
        for (int z = -1; z <= 1; ++z) {
          for (int y = -1; y <= 1; ++y) {
            for (int x = -1; x <= 1; ++x) {
              if (within(x, dx) && within(y, dy) && within(z, dz)) {
                step.needs |= 1u << number(x, y, z);
              }
            }
          }
        }
        step.onward = step.needs & ~(1u << kNoStep);
        if (step.axes == 0) step.onward = kAllAround & ~(1u << kNoStep);
      }
    }
  }
  return all;
}

int first_block(double low_m, double edge_m) {
  return static_cast<int>(std::floor(low_m / edge_m)) / map::kBlockSide - 2;
}
int last_block(double high_m, double edge_m) {
  return static_cast<int>(std::floor(high_m / edge_m)) / map::kBlockSide + 2;
}

}  // namespace

const std::array<Step, kSteps>& steps() {
  static const std::array<Step, kSteps> all = make_steps();
  return all;
}

Grid::Grid(const map::VoxelMap& map) : map_(map), revision_(map.revision()) {
  const double edge = map.config().resolution_m;
  const Vec3 low = map.config().bounds.low(), high = map.config().bounds.high();
  const int bx = first_block(low.x(), edge), by = first_block(low.y(), edge),
            bz = first_block(low.z(), edge);
  origin_ = {bx * map::kBlockSide, by * map::kBlockSide, bz * map::kBlockSide};
  nx_ = last_block(high.x(), edge) - bx + 1;
  ny_ = last_block(high.y(), edge) - by + 1;
  nz_ = last_block(high.z(), edge) - bz + 1;
  views_.resize(blocks());
}

bool Grid::refresh() {
  if (revision_ == map_.revision()) return false;
  revision_ = map_.revision();
  if (++stamp_ == 0) {
    views_.assign(views_.size(), {});
    stamp_ = 1;
  }
  return true;
}

Cell Grid::cell_of(std::uint64_t id) const {
  const int b = static_cast<int>(id >> 12), l = static_cast<int>(id & 4095);
  return {(b % nx_) << 4 | (l & 15), (b / nx_ % ny_) << 4 | (l >> 4 & 15),
          (b / nx_ / ny_) << 4 | l >> 8};
}

void Grid::look_up(std::uint32_t block, View& v) {
  const int b = static_cast<int>(block);
  v.words =
      map_.view({b % nx_ + origin_.x / map::kBlockSide, b / nx_ % ny_ + origin_.y / map::kBlockSide,
                 b / nx_ / ny_ + origin_.z / map::kBlockSide})
          .traversable;
  v.stamp = stamp_;
}

std::uint32_t Grid::three(Cell c) {
  const auto row = [&](int x) -> std::uint32_t {
    const std::uint64_t* words = view(block({x, c.y, c.z}));
    if (!words) return 0;
    const int i = (c.y & 15) | (c.z & 15) << 4;
    return static_cast<std::uint32_t>(words[i >> 2] >> ((i & 3) << 4) & 0xFFFF);
  };
  const int lx = c.x & 15;
  if (lx == 0) return (row(c.x) << 1 & 6) | row(c.x - 1) >> 15;
  if (lx == 15) return row(c.x) >> 14 | (row(c.x + 1) & 1) << 2;
  return row(c.x) >> (lx - 1) & 7;
}

std::uint32_t Grid::around(Cell c) {
  std::uint32_t bits = 0;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      bits |= three({c.x, c.y + dy, c.z + dz}) << (3 * (dy + 1) + 9 * (dz + 1));
    }
  }
  return bits;
}

}  // namespace muster::nav
