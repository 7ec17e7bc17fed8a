#include "common/nav/path_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/nav/flood.h"
#include "common/nav/search.h"
#include "common/nav/supercover.h"

namespace muster::nav {
namespace {

constexpr double kDrift_m = 0.6;  ///< a body this far into clearance still finds its way out

}  // namespace

struct PathFinder::Impl {
  Impl(const map::VoxelMap& m, std::uint32_t limit)
      : map(m), max_expansions(limit), grid(m), search(grid), flood(grid) {}

  void refresh() {
    if (grid.refresh()) flood.invalidate();
  }

  Cell cell(const Vec3& p) const { return grid.cell(map.body_key(p)); }

  /// The traversable voxel nearest to a body, to which it can go without touching anything
  /// occupied.
  std::optional<Cell> way_in(const Vec3& p) {
    const Cell here = cell(p);
    if (!grid.holds(here)) return std::nullopt;
    if (grid.traversable(here)) return here;
    const int reach = static_cast<int>(std::ceil(kDrift_m / map.config().resolution_m));
    std::vector<std::pair<double, Cell>> near;
    for (int dz = -reach; dz <= reach; ++dz) {
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          const Cell c{here.x + dx, here.y + dy, here.z + dz};
          if (!grid.holds(c) || !grid.traversable(c)) continue;
          const double distance = (grid.center(c) - p).norm();
          if (distance <= kDrift_m + 1e-9) near.emplace_back(distance, c);
        }
      }
    }
    std::stable_sort(near.begin(), near.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [distance, c] : near) {
      if (map.line_of_sight(p, grid.center(c), true)) return c;
    }
    return std::nullopt;
  }

  Vec3 in_edges(const Vec3& p) const {
    const map::VoxelKey corner = grid.key(Cell{0, 0, 0});
    return p / map.config().resolution_m - Vec3(corner.x, corner.y, corner.z);
  }

  /// How much of a straight, or of a stretch of the way, is unknown or tight.
  struct Burden {
    std::uint32_t unknown = 0, tight = 0;
    void add(Search& search, Cell c) {
      unknown += search.ground(c) == Ground::kUnknown;
      tight += search.tight(c);
    }
  };

  /// The straight is passable and no worse than the voxels from `first` to `last` of the way that
  /// it replaces.
  bool replaces(const Vec3& a, const Vec3& b, const std::vector<Cell>& way, std::size_t first,
                std::size_t last) {
    Burden old, now;
    for (std::size_t i = first; i <= last; ++i) old.add(search, way[i]);
    return supercover(in_edges(a), in_edges(b), [&](Cell c) {
      const Ground g = search.ground(c);
      if (g != Ground::kKnown && g != Ground::kUnknown) return false;
      now.add(search, c);
      return now.unknown <= old.unknown && now.tight <= old.tight;
    });
  }

  /// String pulling: from each kept point, the farthest point of the way that a straight reaches.
  /// Looks ahead in growing strides, so that long ways stay cheap.
  std::vector<Vec3> shorten(const std::vector<Cell>& way, const std::vector<Vec3>& points) {
    std::vector<Vec3> kept{points.front()};
    for (std::size_t i = 0; i + 1 < points.size();) {
      std::size_t good = i + 1, stride = 1;
      while (good + 1 < points.size()) {
        const std::size_t probe = std::min(good + stride, points.size() - 1);
        if (replaces(points[i], points[probe], way, i, probe)) {
          good = probe;
          stride *= 2;
        } else if (stride > 1) {
          stride = std::max<std::size_t>(1, stride / 4);
        } else {
          break;
        }
      }
      kept.push_back(points[good]);
      i = good;
    }
    return kept;
  }

  /// A UGV's plane is where it stands now, not the middle of a layer of voxels.
  void level(std::vector<Vec3>& points, double z) const {
    if (!map.config().ground) return;
    for (Vec3& p : points) p.z() = z;
  }

  struct Ends {
    Cell start, goal;
    double tolerance_m = 0;
    std::string reason;  ///< empty: both are fine
  };
  Ends ends(const Vec3& start, const Vec3& goal, double tolerance_m, bool through_unknown) {
    Ends e;
    const auto from = way_in(start);
    if (!from) {
      e.reason = "start is not traversable";
      return e;
    }
    e.start = *from;
    e.goal = cell(goal);
    const auto fits = [&](Cell c) {
      return grid.holds(c) && (grid.traversable(c) || (through_unknown && !grid.blocked(c)));
    };
    if (fits(e.goal)) return e;
    e.tolerance_m = tolerance_m;
    const int reach = static_cast<int>(std::ceil(tolerance_m / map.config().resolution_m));
    for (int dz = -reach; dz <= reach; ++dz) {
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          const Cell c{e.goal.x + dx, e.goal.y + dy, e.goal.z + dz};
          if (fits(c) && (grid.center(c) - grid.center(e.goal)).norm() <= tolerance_m) return e;
        }
      }
    }
    e.reason = "goal is not traversable";
    return e;
  }

  /// Points of the way: the body where it is, voxel centres, the goal itself when it is in the last
  /// voxel.
  std::vector<Vec3> points_of(const std::vector<Cell>& way, const Vec3& start,
                              const Vec3& goal) const {
    std::vector<Vec3> points;
    points.reserve(way.size() + 1);
    for (const Cell& c : way) points.push_back(grid.center(c));
    if (cell(start) == way.front()) points.front() = start;
    if (cell(goal) == way.back()) points.back() = goal;
    return points;
  }

  /// In front of a way that begins outside the start's voxel, and behind one of a single voxel: the
  /// body, the goal.
  std::vector<Vec3> closed(std::vector<Vec3> points, const std::vector<Cell>& way,
                           const Vec3& start, const Vec3& goal) const {
    if (cell(start) != way.front()) points.insert(points.begin(), start);
    if (way.size() == 1 && cell(goal) == way.front() && (points.back() - goal).norm() > 1e-9) {
      points.push_back(goal);
    }
    if (points.size() == 1) points.push_back(points.front());
    return points;
  }

  const map::VoxelMap& map;
  std::uint32_t max_expansions;
  Grid grid;
  Search search;
  Flood flood;
};

PathFinder::PathFinder(const map::VoxelMap& map, std::uint32_t max_expansions)
    : impl_(std::make_unique<Impl>(map, max_expansions)) {}
PathFinder::~PathFinder() = default;

namespace {

std::string reason_of(SearchEnd end, bool known_only) {
  if (end == SearchEnd::kLimit) return "search limit";
  return known_only ? "no way through known space" : "no way";
}

}  // namespace

PathResult PathFinder::find(const Vec3& start, const Vec3& goal, double goal_tolerance_m,
                            std::span<const map::Sphere> blocked) {
  Impl& m = *impl_;
  m.refresh();
  const auto ends = m.ends(start, goal, goal_tolerance_m, false);
  if (!ends.reason.empty()) return {std::nullopt, ends.reason};
  // A finished flood from here knows better than a search through everything.
  if (ends.tolerance_m == 0 && m.flood.exhausted() && m.flood.from() == ends.start &&
      m.flood.max_length_m() >= 1e9 && std::isinf(m.flood.distance_m(ends.goal))) {
    return {std::nullopt, reason_of(SearchEnd::kNoWay, true)};
  }
  SearchRequest request;
  request.start = ends.start;
  request.goal = ends.goal;
  request.goal_tolerance_m = ends.tolerance_m;
  request.blocked = blocked;
  request.max_expansions = m.max_expansions;
  const SearchEnd end = m.search.run(request);
  if (end != SearchEnd::kFound) return {std::nullopt, reason_of(end, true)};
  const auto& way = m.search.way();
  Path path{m.closed(m.shorten(way, m.points_of(way, start, goal)), way, start, goal)};
  m.level(path.points, start.z());
  return {std::move(path), {}};
}

PathFinder::Transit PathFinder::find_through_unknown(const Vec3& start, const Vec3& goal,
                                                     double goal_tolerance_m,
                                                     std::span<const map::Sphere> avoid,
                                                     std::span<const map::Sphere> blocked,
                                                     double unknown_factor) {
  Impl& m = *impl_;
  m.refresh();
  const auto ends = m.ends(start, goal, goal_tolerance_m, true);
  if (!ends.reason.empty()) return {std::nullopt, {}, ends.reason};
  SearchRequest request;
  request.start = ends.start;
  request.goal = ends.goal;
  request.goal_tolerance_m = ends.tolerance_m;
  request.blocked = blocked;
  request.through_unknown = true;
  request.unknown_factor = unknown_factor;
  request.avoid = avoid;
  request.max_expansions = m.max_expansions;
  SearchEnd end = m.search.run(request);
  if (end == SearchEnd::kLimit) {
    // A known goal beyond much unknown space: the exact search goes through all of it.
    request.eager = true;
    end = m.search.run(request);
  }
  if (end != SearchEnd::kFound) return {std::nullopt, {}, reason_of(end, false)};

  // The known part ends at the last traversable voxel before the first unknown one; each part is
  // shortened by itself.
  const std::vector<Cell> way = m.search.way();
  const auto points = m.points_of(way, start, goal);
  std::size_t known = 1;
  while (known < way.size() && m.search.ground(way[known]) == Ground::kKnown) ++known;
  const auto cut = static_cast<std::ptrdiff_t>(known);
  const std::vector<Cell> near(way.begin(), way.begin() + cut),
      far(way.begin() + cut - 1, way.end());
  const std::vector<Vec3> near_points(points.begin(), points.begin() + cut),
      far_points(points.begin() + cut - 1, points.end());
  Transit transit;
  transit.known.points = m.closed(m.shorten(near, near_points), near, start, goal);
  transit.path = transit.known;
  const auto beyond = m.shorten(far, far_points);
  transit.path->points.insert(transit.path->points.end(), beyond.begin() + 1, beyond.end());
  m.level(transit.known.points, start.z());
  m.level(transit.path->points, start.z());
  return transit;
}

void PathFinder::flood(const Vec3& start, double max_length_m) {
  Impl& m = *impl_;
  m.refresh();
  const auto from = m.way_in(start);
  if (!from) {
    m.flood.invalidate();
    return;
  }
  if (m.flood.running() && m.flood.from() == *from && m.flood.max_length_m() == max_length_m)
    return;
  m.flood.start(*from, max_length_m);
}

double PathFinder::flood_distance(const Vec3& p) const {
  Impl& m = *impl_;
  // The map changed since the flood: the question is answered on the map of now, from the same
  // start.
  if (m.flood.running() && m.grid.refresh()) {
    const Cell from = m.flood.from();
    if (m.grid.traversable(from)) {
      m.flood.start(from, m.flood.max_length_m());
    } else {
      m.flood.invalidate();
    }
  }
  return m.flood.distance_m(m.cell(p));
}

bool PathFinder::reached(const Vec3& p) const { return std::isfinite(flood_distance(p)); }

bool PathFinder::confined(const Vec3& start, double within_m) {
  flood(start, 3 * within_m);
  Impl& m = *impl_;
  const Cell here = m.cell(start);
  const int far = static_cast<int>(std::ceil(within_m / m.map.config().resolution_m));
  const int up = m.map.config().ground ? 0 : far;
  for (int dz = -up; dz <= up; ++dz) {
    for (int dy = -far; dy <= far; ++dy) {
      for (int dx = -far; dx <= far; ++dx) {
        if (std::max({std::abs(dx), std::abs(dy), std::abs(dz)}) < far) continue;
        const Cell c{here.x + dx, here.y + dy, here.z + dz};
        if (m.grid.holds(c) && std::isfinite(m.flood.distance_m(c))) return false;
      }
    }
  }
  return true;
}

std::vector<double> PathFinder::distances(const Vec3& start, std::span<const Vec3> goals,
                                          double max_length_m) {
  flood(start, max_length_m);
  std::vector<double> lengths;
  for (const Vec3& goal : goals) lengths.push_back(flood_distance(goal));
  return lengths;
}

}  // namespace muster::nav
