#include "common/nav/search.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace muster::nav {
namespace {

constexpr std::array<std::uint32_t, 4> kCost{0, 100, 141,
                                             173};  ///< hundredths of a voxel's edge, by axes
constexpr double kUnitsPerEdge = 100;
constexpr std::uint32_t kTightEighths = 10;  ///< a voxel beside something costs a quarter more
constexpr std::uint32_t kSteepEighths =
    12;  ///< climbing through unknown space, where the camera does not look
constexpr double kMaxUnknownFactor = 8;

}  // namespace

Search::Search(Grid& grid) : grid_(grid), pool_(grid.blocks()), buckets_(kBuckets) {}

void Search::prepare(const SearchRequest& request) {
  request_ = request;
  pool_.clear();
  for (auto& bucket : buckets_) bucket.clear();
  queued_ = 0;
  way_.clear();
  const auto& config = grid_.map().config();
  const double edge = config.resolution_m;
  goal_slack_ =
      request.goal_tolerance_m > 0
          ? static_cast<std::uint32_t>(request.goal_tolerance_m / edge * 1.1 * kUnitsPerEdge) + 100
          : 0;
  unknown_eighths_ = static_cast<std::uint32_t>(
      std::lround(8 * std::clamp(request.unknown_factor, 1.0, kMaxUnknownFactor)));
  keep_out_.assign(request.blocked.begin(), request.blocked.end());
  const Vec3 start = grid_.center(request.start);
  for (auto& sphere : keep_out_) {
    // Near somebody already: away from there is allowed, nearer is not.
    const double grown = sphere.radius_m + config.body_radius_m + config.clearance_m;
    sphere.radius_m = std::min(grown, (start - sphere.center).norm() - edge / 4);
  }
}

/// What may be entered of a block: bodies and places to be avoided are cut out.
void Search::survey(std::uint32_t block, Content& content) {
  content.known.fill(0);
  content.unknown.fill(0);
  const Cell first = grid_.first_of(block);
  if (!grid_.holds(first)) return;
  const Passage& passage = grid_.passage(block);
  for (std::size_t w = 0; w < 64; ++w) {
    content.known[w] = passage.traversable[w];
    if (request_.through_unknown)
      content.unknown[w] = ~passage.traversable[w] & ~passage.blocked[w];
  }
  const double side = map::kBlockSide * grid_.map().config().resolution_m;
  const Vec3 low = grid_.center(first);
  const auto cut = [&](const map::Sphere& s, bool known_too) {
    const Vec3 nearest = s.center.cwiseMax(low).cwiseMin(low + Vec3::Constant(side));
    if (s.radius_m <= 0 || (nearest - s.center).squaredNorm() >= s.radius_m * s.radius_m) return;
    for (std::uint32_t i = 0; i < Grid::kVoxels; ++i) {
      const Cell c = grid_.cell_of(std::uint64_t{block} << 12 | i);
      if ((grid_.center(c) - s.center).squaredNorm() >= s.radius_m * s.radius_m) continue;
      const std::uint64_t others = ~(std::uint64_t{1} << (i & 63));
      content.unknown[i >> 6] &= others;
      if (known_too) content.known[i >> 6] &= others;
    }
  };
  for (const map::Sphere& s : keep_out_) cut(s, true);
  for (const map::Sphere& s : request_.avoid) cut(s, false);
}

Ground Search::ground(Cell c) {
  if (!grid_.holds(c)) return Ground::kNo;
  const Content& here = content(grid_.block(c));
  const std::uint32_t i = Grid::local(c);
  if (here.known[i >> 6] >> (i & 63) & 1) return Ground::kKnown;
  return here.unknown[i >> 6] >> (i & 63) & 1 ? Ground::kUnknown : Ground::kNo;
}

std::uint32_t Search::estimate(Cell c) const {
  const int x = std::abs(c.x - request_.goal.x), y = std::abs(c.y - request_.goal.y),
            z = std::abs(c.z - request_.goal.z);
  const int least = std::min({x, y, z}), most = std::max({x, y, z}),
            middle = x + y + z - least - most;
  const auto h = kCost[3] * static_cast<std::uint32_t>(least) +
                 kCost[2] * static_cast<std::uint32_t>(middle - least) +
                 kCost[1] * static_cast<std::uint32_t>(most - middle);
  return h > goal_slack_ ? h - goal_slack_ : 0;
}

bool Search::at_goal(Cell c) const {
  if (c == request_.goal) return true;
  return goal_slack_ > 0 &&
         (grid_.center(c) - grid_.center(request_.goal)).norm() <= request_.goal_tolerance_m;
}

void Search::push(Cell c, std::uint32_t cost, int step) {
  const std::uint32_t block = grid_.block(c), local = Grid::local(c);
  Content& there = content(block);
  if (there.state[local] & 32 || there.cost[local] <= cost) return;
  there.cost[local] = cost;
  there.state[local] = static_cast<std::uint8_t>((there.state[local] & 0xE0) | step);
  buckets_[(cost + estimate(c)) % kBuckets].push_back(std::uint64_t{block} << 12 | local);
  ++queued_;
}

void Search::expand(Cell c, std::uint32_t cost) {
  const std::uint32_t unknown =
      request_.through_unknown
          ? gather(c, [&](Cell n) { return content(grid_.block(n)).unknown.data(); })
          : 0;
  const std::uint32_t around =
      unknown | gather(c, [&](Cell n) { return content(grid_.block(n)).known.data(); });
  const std::uint32_t here = around == kAllAround ? 8 : kTightEighths;
  for (std::uint32_t tries = around & ~(1u << kNoStep); tries != 0; tries &= tries - 1) {
    const int number = std::countr_zero(tries);
    const Step& step = steps()[static_cast<std::size_t>(number)];
    const std::uint32_t needs = step.needs & ~(1u << kNoStep);
    if ((around & needs) != needs) continue;
    std::uint32_t price = kCost[static_cast<std::size_t>(step.axes)] * here / 8;
    if (unknown & needs) {
      price = price * unknown_eighths_ / 8;
      if (step.dz != 0) price = price * kSteepEighths / 8;
    }
    push({c.x + step.dx, c.y + step.dy, c.z + step.dz}, cost + price, number);
  }
}

void Search::trace(Cell c) {
  for (;;) {
    way_.push_back(c);
    const int number = content(grid_.block(c)).state[Grid::local(c)] & 31;
    if (number == kNoStep) break;
    const Step& step = steps()[static_cast<std::size_t>(number)];
    c = {c.x - step.dx, c.y - step.dy, c.z - step.dz};
  }
  std::reverse(way_.begin(), way_.end());
}

SearchEnd Search::run(const SearchRequest& request) {
  prepare(request);
  push(request.start, 0, kNoStep);
  std::uint32_t expansions = 0;
  for (std::uint32_t level = estimate(request.start); queued_ > 0;) {
    auto& bucket = buckets_[level % kBuckets];
    if (bucket.empty()) {
      ++level;
      continue;
    }
    const std::uint64_t id = bucket.back();
    bucket.pop_back();
    --queued_;
    const auto local = static_cast<std::uint32_t>(id & 4095);
    Content& here = content(static_cast<std::uint32_t>(id >> 12));
    if (here.state[local] & 32) continue;
    here.state[local] |= 32;
    const Cell cell = grid_.cell_of(id);
    if (at_goal(cell)) {
      trace(cell);
      return SearchEnd::kFound;
    }
    if (++expansions > request.max_expansions) return SearchEnd::kLimit;
    expand(cell, here.cost[local]);
  }
  return SearchEnd::kNoWay;
}

}  // namespace muster::nav
