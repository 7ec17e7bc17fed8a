#include "common/nav/flood.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace muster::nav {
namespace {

constexpr std::array<std::uint32_t, 4> kCost{0, 10, 14, 17};  ///< tenths of a voxel's edge, by axes
constexpr double kUnitsPerEdge = 10;

}  // namespace

Flood::Flood(Grid& grid) : grid_(grid), pool_(grid.blocks()) {}

void Flood::start(Cell from, double max_length_m) {
  pool_.clear();
  for (auto& bucket : buckets_) bucket.clear();
  from_ = from;
  max_length_m_ = max_length_m;
  const double units = max_length_m / grid_.map().config().resolution_m * kUnitsPerEdge;
  limit_ = static_cast<std::uint32_t>(std::clamp(units, 0.0, kFar - 1.0));
  cost_ = 0;
  queued_ = 0;
  running_ = true;
  push(from, 0, kNoStep);
}

void Flood::push(Cell to, std::uint32_t cost, int step) {
  if (cost > limit_) return;
  const std::uint32_t block = grid_.block(to), local = Grid::local(to);
  Content& content = pool_.at(block);
  std::uint16_t& best = content.cost[local];
  if (cost > best) return;
  const auto number = static_cast<std::uint8_t>(step);
  if (cost == best) {
    // Equally short from another side: the onward steps of both, for simplicity of all.
    if (content.step[local] != number) content.step[local] = kNoStep;
    return;
  }
  best = static_cast<std::uint16_t>(cost);
  content.step[local] = number;
  buckets_[cost % kBuckets].push_back(std::uint64_t{block} << 12 | local);
  ++queued_;
}

void Flood::expand(std::uint64_t id) {
  const auto local = static_cast<std::uint32_t>(id & 4095);
  const Content& content = pool_.at(static_cast<std::uint32_t>(id >> 12));
  if (content.cost[local] < cost_) return;
  const Cell cell = grid_.cell_of(id);
  const std::uint32_t around = grid_.around(cell);
  std::uint32_t tries =
      around == kAllAround ? steps()[content.step[local]].onward : around & ~(1u << kNoStep);
  for (; tries != 0; tries &= tries - 1) {
    const int number = std::countr_zero(tries);
    const Step& step = steps()[static_cast<std::size_t>(number)];
    if ((around & step.needs & ~(1u << kNoStep)) != (step.needs & ~(1u << kNoStep))) continue;
    push({cell.x + step.dx, cell.y + step.dy, cell.z + step.dz},
         cost_ + kCost[static_cast<std::size_t>(step.axes)], number);
  }
}

void Flood::settle(Cell to) {
  const std::uint32_t block = grid_.block(to), local = Grid::local(to);
  while (queued_ > 0) {
    const Content* content = pool_.find(block);
    if (content && content->cost[local] <= cost_) return;
    auto& bucket = buckets_[cost_ % kBuckets];
    for (std::size_t i = 0; i < bucket.size(); ++i) expand(bucket[i]);
    queued_ -= bucket.size();
    bucket.clear();
    ++cost_;
  }
}

double Flood::distance_m(Cell to) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (!running_ || !grid_.holds(to)) return kNever;
  if (to == from_) return 0;
  if (!grid_.traversable(to)) return kNever;
  settle(to);
  const Content* content = pool_.find(grid_.block(to));
  if (!content || content->cost[Grid::local(to)] == kFar) return kNever;
  return content->cost[Grid::local(to)] / kUnitsPerEdge * grid_.map().config().resolution_m;
}

}  // namespace muster::nav
