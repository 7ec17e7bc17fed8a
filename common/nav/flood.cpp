#include "common/nav/flood.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace muster::nav {
namespace {

constexpr std::array<std::uint32_t, 4> kCost{0, 10, 14, 17};  ///< tenths of a voxel's edge, by axes
constexpr double kUnitsPerEdge = 10;

/// A step from one of the 27 voxels of a neighbourhood to another.
struct Link {
  std::uint32_t needs;  ///< voxels that must be free, as neighbour bits
  int to, axes;
};

/// All steps within a neighbourhood that do not touch its centre, by where they begin.
const std::array<std::vector<Link>, kSteps>& links() {
  static const std::array<std::vector<Link>, kSteps> all = [] {
    std::array<std::vector<Link>, kSteps> result;
    const auto inside = [](int v) { return v >= -1 && v <= 1; };
    for (const Step& from : steps()) {
      for (const Step& step : steps()) {
        const int x = from.dx + step.dx, y = from.dy + step.dy, z = from.dz + step.dz;
        if (step.axes == 0 || !inside(x) || !inside(y) || !inside(z)) continue;
        Link link{0, detail::step_number(x, y, z), step.axes};
        for (int i = 0; i < kSteps; ++i) {
          const Step& part = steps()[static_cast<std::size_t>(i)];
          if (!(step.needs >> i & 1)) continue;
          link.needs |=
              1u << detail::step_number(from.dx + part.dx, from.dy + part.dy, from.dz + part.dz);
        }
        const auto begin = detail::step_number(from.dx, from.dy, from.dz);
        if (begin != kNoStep && link.to != kNoStep)
          result[static_cast<std::size_t>(begin)].push_back(link);
      }
    }
    return result;
  }();
  return all;
}

/// The steps from a voxel, entered by `step`, that are worth trying with these neighbours free.
std::uint32_t worth_trying(int step, std::uint32_t around) {
  const std::uint32_t all = around & ~(1u << kNoStep);
  if (step == kNoStep) return all;
  if (around == kAllAround) return steps()[static_cast<std::size_t>(step)].onward;
  const Step& came = steps()[static_cast<std::size_t>(step)];
  const int from = detail::step_number(-came.dx, -came.dy, -came.dz);
  // Shortest ways around the voxel from where the step began, and the most axes that the first
  // step of one has: 27 voxels, settled in order of distance.
  constexpr std::uint32_t kFar = 1000;
  std::array<std::uint32_t, kSteps> cost;
  std::array<int, kSteps> first{};
  cost.fill(kFar);
  cost[static_cast<std::size_t>(from)] = 0;
  std::uint32_t open = 1u << from;
  while (open != 0) {
    int next = std::countr_zero(open);
    for (std::uint32_t rest = open & (open - 1); rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest);
      if (cost[static_cast<std::size_t>(i)] < cost[static_cast<std::size_t>(next)]) next = i;
    }
    open &= ~(1u << next);
    const auto at = static_cast<std::size_t>(next);
    for (const Link& link : links()[at]) {
      if ((around & link.needs) != link.needs) continue;
      const auto to = static_cast<std::size_t>(link.to);
      const std::uint32_t then = cost[at] + kCost[static_cast<std::size_t>(link.axes)];
      const int begins = next == from ? link.axes : first[at];
      if (then > cost[to] || (then == cost[to] && begins <= first[to])) continue;
      cost[to] = then;
      first[to] = begins;
      open |= 1u << link.to;
    }
  }
  std::uint32_t worth = 0;
  for (std::uint32_t tries = all; tries != 0; tries &= tries - 1) {
    const auto to = static_cast<std::size_t>(std::countr_zero(tries));
    const std::uint32_t through = kCost[static_cast<std::size_t>(came.axes)] +
                                  kCost[static_cast<std::size_t>(steps()[to].axes)];
    if (cost[to] < through || (cost[to] == through && first[to] > came.axes)) continue;
    worth |= 1u << to;
  }
  return worth;
}

}  // namespace

Flood::Flood(Grid& grid) : grid_(grid), pool_(grid.blocks()), worth_(kRemembered) {}

std::uint32_t Flood::worth(int step, std::uint32_t around) {
  const std::uint32_t key = around | static_cast<std::uint32_t>(step) << kSteps;
  Worth& remembered = worth_[key * 2654435761u >> 18];
  if (remembered.around != key) remembered = {key, worth_trying(step, around)};
  return remembered.steps;
}

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
  for (std::uint32_t tries = worth(content.step[local], around); tries != 0; tries &= tries - 1) {
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
