#include "common/nav/grid.h"

#include <cmath>

namespace muster::nav {
namespace {

constexpr std::array<std::uint64_t, 64> kNone{};
constexpr std::array<std::uint64_t, 64> kAll = [] {
  std::array<std::uint64_t, 64> all{};
  all.fill(~std::uint64_t{0});
  return all;
}();

int first_block(double low_m, double edge_m) {
  return static_cast<int>(std::floor(low_m / edge_m)) / map::kBlockSide - 2;
}
int last_block(double high_m, double edge_m) {
  return static_cast<int>(std::floor(high_m / edge_m)) / map::kBlockSide + 2;
}

}  // namespace

Grid::Grid(const map::VoxelMap& map) : map_(map) {
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
  // What a changed block blocks reaches into its neighbours. Other views stay: they point into the
  // map, and asking it for one brings all up to date.
  for (const map::BlockKey& b : map_.changes(changes_)) {
    map_.view(b);
    const Cell c = cell({b.x * map::kBlockSide, b.y * map::kBlockSide, b.z * map::kBlockSide});
    if (!holds(c)) continue;
    for (int i = 0; i < kSteps; ++i) {
      const Step& step = steps()[static_cast<std::size_t>(i)];
      views_[block({c.x + (step.dx << 4), c.y + (step.dy << 4), c.z + (step.dz << 4)})].seen =
          false;
    }
  }
  return true;
}

Cell Grid::cell_of(std::uint64_t id) const {
  const int b = static_cast<int>(id >> 12), l = static_cast<int>(id & 4095);
  return {(b % nx_) << 4 | (l & 15), (b / nx_ % ny_) << 4 | (l >> 4 & 15),
          (b / nx_ / ny_) << 4 | l >> 8};
}

void Grid::look_up(std::uint32_t block, View& v) {
  v.seen = true;
  v.blocked.reset();
  const map::BlockKey b = block_key(block);
  if (const map::BlockView known = map_.view(b)) {
    v.passage = {known.traversable, known.blocked};
    return;
  }
  const Plane blocked = map_.blocked_where_unknown(b);
  v.passage = {kNone.data(), blocked == kNone ? kNone.data() : kAll.data()};
  if (blocked != kNone && blocked != kAll) {
    v.blocked = std::make_unique<Plane>(blocked);
    v.passage.blocked = v.blocked->data();
  }
}

}  // namespace muster::nav
