#include "common/nav/search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>

namespace muster::nav {
namespace {

constexpr std::array<std::uint32_t, 4> kCost{0, 100, 141,
                                             173};  ///< hundredths of a voxel's edge, by axes
constexpr double kUnitsPerEdge = 100;
constexpr std::uint8_t kStep = 31, kClosed = 32, kConnected = 64;
constexpr Cell kFaces[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
constexpr std::uint32_t kTightEighths = 10;  ///< a voxel beside something costs a quarter more
constexpr std::uint32_t kSteepEighths =
    12;  ///< climbing through unknown space, where the camera does not look
constexpr std::uint32_t kDoubtAfter = 2000;  ///< expansions: maybe there is no way at all
constexpr std::size_t kBucketKeeps = 64;
constexpr double kMaxUnknownFactor = 6;  ///< the dearest step and back fit into the buckets

}  // namespace

Search::Search(Grid& grid) : grid_(grid), pool_(grid.blocks()), buckets_(kBuckets) {}

void Search::prepare(const SearchRequest& request) {
  request_ = request;
  pool_.clear();
  for (auto& bucket : buckets_) {
    bucket.clear();
    if (bucket.capacity() > kBucketKeeps) bucket.shrink_to_fit();
  }
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
  heap_.clear();
  connected_.clear();
  met_ = false;
  straight_ = Vec3(request.goal.x - request.start.x, request.goal.y - request.start.y,
                   request.goal.z - request.start.z);
  straight_length_ = std::max(1.0, straight_.norm());
  eager_ = request.through_unknown && (request.eager || ground(request.goal) != Ground::kKnown);
  for (int axes = 1; axes <= 3; ++axes) {
    level_[static_cast<std::size_t>(axes)] = price(axes, 8, eager_, false);
    steep_[static_cast<std::size_t>(axes)] = price(axes, 8, eager_, true);
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

std::uint32_t Search::price(int axes, std::uint32_t eighths, bool unknown, bool steep) const {
  std::uint32_t price = kCost[static_cast<std::size_t>(axes)] * eighths / 8;
  if (unknown) price = price * unknown_eighths_ / 8;
  if (unknown && steep) price = price * kSteepEighths / 8;
  return price;
}

/// What the way to the goal costs where nothing is in its way: as many steps along all three axes
/// as there can be, then along two, then straight.
std::uint32_t Search::estimate(Cell c) const {
  const int x = std::abs(c.x - request_.goal.x), y = std::abs(c.y - request_.goal.y),
            z = std::abs(c.z - request_.goal.z);
  const int near = std::min(x, y), far = std::max(x, y);
  const int three = std::min(near, z), steep_two = std::min(far, z) - three, two = near - three,
            steep_one = z - three - steep_two, one = far - three - steep_two - two;
  const auto cost = [](int steps, std::uint32_t price) {
    return static_cast<std::uint32_t>(steps) * price;
  };
  const std::uint32_t h = cost(three, steep_[3]) + cost(steep_two, steep_[2]) +
                          cost(two, level_[2]) + cost(steep_one, steep_[1]) + cost(one, level_[1]);
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
  if (there.state[local] & kClosed || there.cost[local] <= cost) return;
  there.cost[local] = cost;
  there.state[local] = static_cast<std::uint8_t>((there.state[local] & ~kStep) | step);
  const std::uint64_t id = std::uint64_t{block} << 12 | local;
  const std::uint32_t total = cost + estimate(c);
  if (eager_) {
    heap_.push_back({std::uint64_t{total} << 32 | aside(c), id});
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
  } else {
    buckets_[total % kBuckets].push_back(id);
    ++queued_;
  }
}

/// The voxel to be expanded next; nullopt when there is none.
std::optional<std::uint64_t> Search::pop() {
  std::uint64_t id = 0;
  if (eager_) {
    if (heap_.empty()) return std::nullopt;
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    id = heap_.back().second;
    heap_.pop_back();
  } else {
    if (queued_ == 0) return std::nullopt;
    while (buckets_[now_ % kBuckets].empty()) ++now_;
    std::vector<std::uint64_t>& bucket = buckets_[now_ % kBuckets];
    id = bucket.back();
    bucket.pop_back();
    // Every bucket is long at some time; if all kept that room, it came to 19 MB.
    if (bucket.empty() && bucket.capacity() > kBucketKeeps) bucket = std::vector<std::uint64_t>();
    --queued_;
  }
  return id;
}

/// How far from the straight between start and goal, in eighths of a voxel's edge.
std::uint32_t Search::aside(Cell c) const {
  const Vec3 from_start(c.x - request_.start.x, c.y - request_.start.y, c.z - request_.start.z);
  return static_cast<std::uint32_t>(8 * straight_.cross(from_start).norm() / straight_length_);
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
    push({c.x + step.dx, c.y + step.dy, c.z + step.dz},
         cost + price(step.axes, here, unknown & needs, step.dz != 0), number);
  }
}

void Search::connect(Cell c) {
  if (ground(c) == Ground::kNo) return;
  std::uint8_t& state = content(grid_.block(c)).state[Grid::local(c)];
  if (state & kConnected) return;
  met_ = met_ || state & kClosed;
  state |= kConnected;
  connected_.push_back(grid_.id(c));
}

/// A search that takes long fills the place from the goal as well, voxel for voxel: where the goal
/// is walled in, that ends soon. What 6 neighbours connect is what all 26 do (no corner is cut).
bool Search::sealed() {
  if (connected_.empty()) {
    const int reach =
        static_cast<int>(std::ceil(request_.goal_tolerance_m / grid_.map().config().resolution_m));
    for (int dz = -reach; dz <= reach; ++dz) {
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          const Cell c{request_.goal.x + dx, request_.goal.y + dy, request_.goal.z + dz};
          if (at_goal(c)) connect(c);
        }
      }
    }
  } else {
    const Cell c = grid_.cell_of(connected_.back());
    connected_.pop_back();
    for (const Cell& f : kFaces) connect({c.x + f.x, c.y + f.y, c.z + f.z});
  }
  return connected_.empty() && !met_;
}

void Search::trace(Cell c) {
  for (;;) {
    way_.push_back(c);
    const int number = content(grid_.block(c)).state[Grid::local(c)] & kStep;
    if (number == kNoStep) break;
    const Step& step = steps()[static_cast<std::size_t>(number)];
    c = {c.x - step.dx, c.y - step.dy, c.z - step.dz};
  }
  std::reverse(way_.begin(), way_.end());
}

SearchEnd Search::run(const SearchRequest& request) {
  prepare(request);
  now_ = estimate(request.start);
  push(request.start, 0, kNoStep);
  std::uint32_t expansions = 0;
  while (const auto next = pop()) {
    const std::uint64_t id = *next;
    const auto local = static_cast<std::uint32_t>(id & 4095);
    Content& here = content(static_cast<std::uint32_t>(id >> 12));
    if (here.state[local] & kClosed) continue;
    here.state[local] |= kClosed;
    const Cell cell = grid_.cell_of(id);
    if (at_goal(cell)) {
      trace(cell);
      return SearchEnd::kFound;
    }
    if (++expansions > request.max_expansions) return SearchEnd::kLimit;
    if (expansions >= kDoubtAfter && !met_ && sealed()) return SearchEnd::kNoWay;
    expand(cell, here.cost[local]);
  }
  return SearchEnd::kNoWay;
}

}  // namespace muster::nav
