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

Ground Search::judge(Cell c) const {
  if (!grid_.holds(c)) return Ground::kNo;
  const Vec3 p = grid_.center(c);
  const auto within = [&](const map::Sphere& s) {
    return s.radius_m > 0 && (p - s.center).squaredNorm() < s.radius_m * s.radius_m;
  };
  if (std::any_of(keep_out_.begin(), keep_out_.end(), within)) return Ground::kNo;
  if (grid_.traversable(c)) return Ground::kKnown;
  if (!request_.through_unknown || grid_.map().blocked(grid_.key(c))) return Ground::kNo;
  return std::any_of(request_.avoid.begin(), request_.avoid.end(), within) ? Ground::kNo
                                                                           : Ground::kUnknown;
}

Ground Search::ground(Cell c) {
  if (!grid_.holds(c)) return Ground::kNo;
  std::uint8_t& state = pool_.at(grid_.block(c)).state[Grid::local(c)];
  if (state >> 6 == 0)
    state = static_cast<std::uint8_t>(state | static_cast<unsigned>(judge(c)) << 6);
  return static_cast<Ground>(state >> 6);
}

std::uint32_t Search::passable_around(Cell c, std::uint32_t& unknown) {
  unknown = 0;
  if (keep_out_.empty() && !request_.through_unknown) return grid_.around(c);
  std::uint32_t bits = 0;
  for (int i = 0; i < kSteps; ++i) {
    const Step& step = steps()[static_cast<std::size_t>(i)];
    const Ground g = ground({c.x + step.dx, c.y + step.dy, c.z + step.dz});
    if (g == Ground::kKnown || g == Ground::kUnknown) bits |= 1u << i;
    if (g == Ground::kUnknown) unknown |= 1u << i;
  }
  return bits;
}

std::uint32_t Search::estimate(Cell c) const {
  std::array<int, 3> d{std::abs(c.x - request_.goal.x), std::abs(c.y - request_.goal.y),
                       std::abs(c.z - request_.goal.z)};
  std::sort(d.begin(), d.end());
  const auto h = kCost[3] * static_cast<std::uint32_t>(d[0]) +
                 kCost[2] * static_cast<std::uint32_t>(d[1] - d[0]) +
                 kCost[1] * static_cast<std::uint32_t>(d[2] - d[1]);
  return h > goal_slack_ ? h - goal_slack_ : 0;
}

bool Search::at_goal(Cell c) const {
  if (c == request_.goal) return true;
  return goal_slack_ > 0 &&
         (grid_.center(c) - grid_.center(request_.goal)).norm() <= request_.goal_tolerance_m;
}

void Search::push(Cell c, std::uint32_t cost, int step) {
  const std::uint32_t block = grid_.block(c), local = Grid::local(c);
  Content& content = pool_.at(block);
  if (content.state[local] & 32 || content.cost[local] <= cost) return;
  content.cost[local] = cost;
  content.state[local] = static_cast<std::uint8_t>((content.state[local] & 0xE0) | step);
  buckets_[(cost + estimate(c)) % kBuckets].push_back(std::uint64_t{block} << 12 | local);
  ++queued_;
}

void Search::expand(Cell c, std::uint32_t cost) {
  std::uint32_t unknown = 0;
  const std::uint32_t around = passable_around(c, unknown);
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
    const Content& content = pool_.at(grid_.block(c));
    const int number = content.state[Grid::local(c)] & 31;
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
    Content& content = pool_.at(static_cast<std::uint32_t>(id >> 12));
    if (content.state[local] & 32) continue;
    content.state[local] |= 32;
    const Cell cell = grid_.cell_of(id);
    if (at_goal(cell)) {
      trace(cell);
      return SearchEnd::kFound;
    }
    if (++expansions > request.max_expansions) return SearchEnd::kLimit;
    expand(cell, content.cost[local]);
  }
  return SearchEnd::kNoWay;
}

}  // namespace muster::nav
