#include "common/nav/path_finder.h"

#include <rapidcheck.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <set>

#include "common/core/random.h"
#include "tests/unit/map/said.h"
#include "tests/unit/nav/known_map.h"

using namespace muster;
using namespace muster::nav;
using muster::test::below;
using muster::test::KnownMap;

namespace {

/// A room with pillars, walls and unknown lumps.
KnownMap random_rooms(Random& random, map::VoxelKey size, int things) {
  KnownMap rooms({0, 0, 0}, size);
  for (int i = 0; i < things; ++i) {
    const map::VoxelKey at{below(random, size.x), below(random, size.y), below(random, size.z)};
    const map::VoxelKey extent{1 + below(random, random.chance(0.3) ? size.x : 3),
                               1 + below(random, 3),
                               1 + below(random, random.chance(0.3) ? size.z : 3)};
    const auto what = random.chance(0.8) ? map::Voxel::kOccupied : map::Voxel::kUnknown;
    for (int z = at.z; z < std::min(size.z, at.z + extent.z); ++z) {
      for (int y = at.y; y < std::min(size.y, at.y + extent.y); ++y) {
        for (int x = at.x; x < std::min(size.x, at.x + extent.x); ++x) rooms.set({x, y, z}, what);
      }
    }
  }
  return rooms;
}

std::vector<map::VoxelKey> traversable_voxels(const map::VoxelMap& map, map::VoxelKey size) {
  std::vector<map::VoxelKey> found;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        if (map.traversable(map::VoxelKey{x, y, z})) found.push_back({x, y, z});
      }
    }
  }
  return found;
}

/// Plain Dijkstra over all 26 steps that cut no corner, costs 10, 14, 17.
std::map<map::VoxelKey, int> reference(const map::VoxelMap& map, map::VoxelKey from) {
  std::map<map::VoxelKey, int> cost{{from, 0}};
  std::set<std::pair<int, map::VoxelKey>> open{{0, from}};
  const auto box_free = [&](map::VoxelKey k, int dx, int dy, int dz) {
    for (const int x : {0, dx}) {
      for (const int y : {0, dy}) {
        for (const int z : {0, dz}) {
          if (!map.traversable(map::VoxelKey{k.x + x, k.y + y, k.z + z})) return false;
        }
      }
    }
    return true;
  };
  while (!open.empty()) {
    const auto [g, k] = *open.begin();
    open.erase(open.begin());
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int axes = std::abs(dx) + std::abs(dy) + std::abs(dz);
          if (axes == 0 || !box_free(k, dx, dy, dz)) continue;
          const map::VoxelKey n{k.x + dx, k.y + dy, k.z + dz};
          const int then = g + (axes == 1 ? 10 : axes == 2 ? 14 : 17);
          const auto known = cost.find(n);
          if (known != cost.end() && known->second <= then) continue;
          if (known != cost.end()) open.erase({known->second, n});
          cost[n] = then;
          open.insert({then, n});
        }
      }
    }
  }
  return cost;
}

/// Every point of the path is in a traversable voxel, or on the border of one.
bool stays_traversable(const map::VoxelMap& map, const Path& path) {
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    const Vec3 a = path.points[i - 1], d = path.points[i] - a;
    const int n = static_cast<int>(d.norm() / 0.005) + 1;
    for (int k = 0; k <= n; ++k) {
      const Vec3 p = a + d * (double(k) / n);
      if (!map.traversable(p)) return false;
    }
  }
  return true;
}

/// CPU time: the machine may be busy.
double ms_since(std::clock_t start) { return 1e3 * double(std::clock() - start) / CLOCKS_PER_SEC; }

}  // namespace

TEST_CASE(
    "paths stay in traversable space, and none is found exactly when a full search finds none") {
  const auto whatever = [] {
    const auto seed = *rc::gen::arbitrary<std::uint32_t>();
    Random random(seed, RobotId{0}, "rooms");
    const map::VoxelKey size{36, 36, 20};
    auto rooms = random_rooms(random, size, 40);
    const auto& map = rooms.map();
    const auto voxels = traversable_voxels(map, size);
    if (voxels.empty()) return;
    PathFinder finder(map);
    const auto from = voxels[random.below(voxels.size())];
    const auto costs = reference(map, from);
    for (int trial = 0; trial < 6; ++trial) {
      const auto to = voxels[random.below(voxels.size())];
      const auto result = finder.find(map.center(from), map.center(to));
      RC_ASSERT(result.path.has_value() == costs.contains(to));
      if (!result.path) {
        RC_ASSERT(result.reason == "no way through known space");
        continue;
      }
      RC_ASSERT((result.path->points.front() - map.center(from)).norm() < 1e-9);
      RC_ASSERT((result.path->points.back() - map.center(to)).norm() < 1e-9);
      RC_ASSERT(stays_traversable(map, *result.path));
      RC_ASSERT(result.path->length_m() <= 1.5 * costs.at(to) * 0.02 + 0.5);
    }
  };
  CHECK(rc::check("paths", whatever));
}

TEST_CASE("the flood's distances are those of a plain search, in whatever order they are asked") {
  const auto whatever = [] {
    const auto seed = *rc::gen::arbitrary<std::uint32_t>();
    Random random(seed, RobotId{0}, "flood");
    const map::VoxelKey size{34, 34, 18};
    auto rooms = random_rooms(random, size, static_cast<int>(random.below(50)));
    const auto& map = rooms.map();
    const auto voxels = traversable_voxels(map, size);
    if (voxels.empty()) return;
    const auto from = voxels[random.below(voxels.size())];
    const auto costs = reference(map, from);
    PathFinder finder(map);
    finder.flood(map.center(from));
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const auto k = voxels[random.below(voxels.size())];
      const double d = finder.flood_distance(map.center(k));
      RC_ASSERT(finder.reached(map.center(k)) == costs.contains(k));
      if (costs.contains(k)) RC_ASSERT(std::abs(d - costs.at(k) * 0.02) < 1e-9);
    }
  };
  CHECK(rc::check("flood", whatever));
}

TEST_CASE("a flood ends at its maximum length") {
  KnownMap hall({0, 0, 0}, {100, 10, 10});
  PathFinder finder(hall.map());
  const std::vector<Vec3> goals{Vec3(3, 1, 1), Vec3(15, 1, 1)};
  const auto lengths = finder.distances(Vec3(1, 1, 1), goals, 5);
  CHECK(lengths[0] == Approx(2).margin(0.21));
  CHECK(std::isinf(lengths[1]));
  CHECK(finder.distances(Vec3(1, 1, 1), goals)[1] == Approx(14).margin(0.21));
}

TEST_CASE("a new map is seen by the next question") {
  KnownMap hall({0, 0, 0}, {100, 10, 10});
  auto& map = hall.map();
  PathFinder finder(map);
  finder.flood(Vec3(1, 1, 1));
  CHECK(finder.reached(Vec3(15, 1, 1)));
  CHECK(finder.find(Vec3(1, 1, 1), Vec3(15, 1, 1)).path);
  std::vector<map::Voxel> wall(4096, map::Voxel::kOccupied);
  map.merge(RobotId{98}, map::said({3, 0, 0}, wall));
  CHECK_FALSE(finder.reached(Vec3(15, 1, 1)));
  CHECK_FALSE(finder.find(Vec3(1, 1, 1), Vec3(15, 1, 1)).path);
}

TEST_CASE("in the open the path is one straight") {
  KnownMap hall({0, 0, 0}, {100, 60, 20});
  PathFinder finder(hall.map());
  const Vec3 a(1.03, 1.11, 1.3), b(17.2, 9.91, 2.77);
  const auto result = finder.find(a, b);
  REQUIRE(result.path);
  CHECK(result.path->points == std::vector<Vec3>{a, b});
}

TEST_CASE("a body inside clearance finds its way out; one far from any way does not") {
  KnownMap hall({0, 0, 0}, {100, 30, 20});
  for (int y = 0; y < 30; ++y) {
    for (int z = 0; z < 20; ++z) hall.occupy({50, y, z});
  }
  PathFinder finder(hall.map());
  const Vec3 close(9.9, 3, 2);
  const auto result = finder.find(close, Vec3(2, 3, 2));
  REQUIRE(result.path);
  CHECK(result.path->points.front() == close);
  CHECK(result.path->points[1].x() < close.x());
  CHECK(finder.find(Vec3(2, 3, -3), Vec3(2, 3, 2)).reason == "start is not traversable");
}

TEST_CASE("a goal inside clearance is taken as near as the tolerance allows") {
  KnownMap hall({0, 0, 0}, {50, 30, 20});
  PathFinder finder(hall.map());
  const Vec3 edge(0.15, 3, 2);
  CHECK(finder.find(Vec3(5, 3, 2), edge, 0.05).reason == "goal is not traversable");
  const auto result = finder.find(Vec3(5, 3, 2), edge, 0.5);
  REQUIRE(result.path);
  CHECK((result.path->points.back() - edge).norm() <= 0.7);
}

TEST_CASE("a path keeps away from bodies that stand about, and leaves one it is close to") {
  KnownMap hall({0, 0, 0}, {60, 30, 20});
  PathFinder finder(hall.map());
  const std::vector<map::Sphere> parked{{Vec3(6, 3, 2), 0.5}};
  const auto result = finder.find(Vec3(1, 3, 2), Vec3(11, 3, 2), 0.3, parked);
  REQUIRE(result.path);
  for (double u = 0; u <= 1; u += 0.001) {
    const auto& points = result.path->points;
    const auto i = static_cast<std::size_t>(u * double(points.size() - 1) * 0.9999);
    const double w = u * double(points.size() - 1) - double(i);
    CHECK((points[i] + w * (points[i + 1] - points[i]) - parked[0].center).norm() > 0.7);
  }
  CHECK(finder.find(Vec3(6.3, 3, 2), Vec3(11, 3, 2), 0.3, parked).path);
}

TEST_CASE("a ground vehicle's path is level, around walls, on its driving plane") {
  map::MapConfig config;
  config.ground = true;
  KnownMap plane({0, 0, 2}, {60, 40, 3}, config);
  for (int y = 0; y < 30; ++y) plane.occupy({30, y, 2});
  PathFinder finder(plane.map());
  const auto result = finder.find(Vec3(2, 2, 0.4), Vec3(10, 2, 0.4));
  REQUIRE(result.path);
  CHECK(result.path->length_m() > 12);
  for (const Vec3& p : result.path->points) CHECK(p.z() == 0.4);
}

TEST_CASE("transit goes through unknown space but hands out only the known part to fly") {
  KnownMap half({0, 0, 0}, {30, 30, 20});
  for (int y = 0; y < 20; ++y) {
    for (int z = 0; z < 20; ++z) half.occupy({28, y, z});
  }
  PathFinder finder(half.map());
  const Vec3 start(1, 1, 2), goal(12, 1, 2);
  CHECK_FALSE(finder.find(start, goal).path);
  const auto transit = finder.find_through_unknown(start, goal, 0.3);
  REQUIRE(transit.path);
  CHECK((transit.path->points.back() - goal).norm() < 1e-9);
  CHECK(stays_traversable(half.map(), transit.known));
  CHECK(transit.known.length_m() > 3);
  CHECK(transit.path->length_m() > transit.known.length_m() + 3);
  for (const Vec3& p : transit.path->points) CHECK_FALSE(half.map().blocked(half.map().key(p)));
  // The same through space that led nowhere before.
  const std::vector<map::Sphere> avoid{{transit.path->points[transit.known.points.size()], 1.0}};
  const auto other = finder.find_through_unknown(start, goal, 0.3, avoid);
  REQUIRE(other.path);
  CHECK(other.path->points != transit.path->points);
}

TEST_CASE("a known goal beyond much unknown space is found with few expansions") {
  KnownMap two({0, 0, 0}, {12, 12, 12});
  for (int z = 0; z < 12; ++z) {
    for (int y = 100; y < 112; ++y) {
      for (int x = 150; x < 162; ++x) two.set({x, y, z}, map::Voxel::kFree);
    }
  }
  PathFinder finder(two.map(), 20'000);
  const Vec3 goal(31.1, 21.1, 1.1);
  const auto way = finder.find_through_unknown(Vec3(1, 1, 1), goal, 0.3);
  REQUIRE(way.path);
  CHECK(way.path->length_m() < 1.3 * (goal - Vec3(1, 1, 1)).norm());
}

TEST_CASE("transit to a far unknown goal costs hardly more than the straight") {
  map::MapConfig config;
  config.bounds = Box::from_corners(Vec3(-20, -20, -1), Vec3(140, 60, 20));
  KnownMap ball({0, 0, 0}, {12, 12, 12}, config);
  const Vec3 start(1, 1, 1), goal(120, 40, 2);
  PathFinder few(ball.map(), 3000);  // an exact search needs millions
  const auto transit = few.find_through_unknown(start, goal, 0.3);
  REQUIRE(transit.path);
  CHECK(transit.path->length_m() < 1.1 * (goal - start).norm());
  REQUIRE(transit.known.points.size() >= 2);
  const Vec3 first = (transit.known.points.back() - start).normalized();
  CHECK(first.dot((goal - start).normalized()) > 0.6);
}

TEST_CASE("an unknown goal that is walled in is found out from within") {
  map::MapConfig config;
  config.bounds = Box::from_corners(Vec3(-60, -60, -1), Vec3(60, 60, 20));
  KnownMap tomb({0, 0, 0}, {80, 20, 20}, config);
  for (int z = 0; z < 20; ++z) {
    for (int y = 0; y < 20; ++y) {
      for (int x = 50; x < 70; ++x) {
        const bool inside = x > 51 && x < 68 && y > 1 && y < 18 && z > 1 && z < 18;
        tomb.set({x, y, z}, inside ? map::Voxel::kUnknown : map::Voxel::kOccupied);
      }
    }
  }
  PathFinder finder(tomb.map(), 12'000);  // the open around it has millions of voxels
  const auto transit = finder.find_through_unknown(Vec3(2, 2, 2), Vec3(12, 2, 2), 0.3);
  CHECK_FALSE(transit.path);
  CHECK(transit.reason == "no way");
}

TEST_CASE(
    "what a block without a single known voxel blocks is what its neighbours and bounds say") {
  Random random(3, RobotId{0}, "edge");
  map::MapConfig config;
  config.bounds = Box::from_corners(Vec3(-3.7, -9.1, -1), Vec3(9.3, 12, 9));
  KnownMap bounded({0, 0, 0}, {32, 32, 16}, config);
  for (int i = 0; i < 300; ++i) {
    bounded.occupy({below(random, 32), below(random, 32), below(random, 16)});
  }
  const auto& map = bounded.map();
  int unknown_blocks = 0;
  for (int bz = -2; bz <= 3; ++bz) {
    for (int by = -3; by <= 4; ++by) {
      for (int bx = -3; bx <= 3; ++bx) {
        if (map.view({bx, by, bz})) continue;
        ++unknown_blocks;
        const auto plane = map.blocked_where_unknown({bx, by, bz});
        for (int i = 0; i < 4096; i += 7) {
          const map::VoxelKey k{bx * 16 + (i & 15), by * 16 + (i >> 4 & 15), bz * 16 + (i >> 8)};
          const bool bit = plane[static_cast<std::size_t>(i >> 6)] >> (i & 63) & 1;
          if (bit != map.blocked(k)) FAIL(k.x << " " << k.y << " " << k.z);
        }
      }
    }
  }
  CHECK(unknown_blocks > 100);
}

TEST_CASE("a change reaches searches also where it lies across a block's border") {
  KnownMap hall({0, 0, 0}, {64, 16, 16});
  auto& map = hall.map();
  PathFinder finder(map);
  CHECK(finder.find_through_unknown(Vec3(1, 1.5, 1.5), Vec3(20, 1.5, 1.5), 0.3).path);
  // Unknown space beyond x = 12.8 is blocked by walls in the last known block only.
  std::vector<map::Voxel> wall(4096, map::Voxel::kFree);
  for (int i = 0; i < 4096; ++i) {
    if ((i & 15) == 15) wall[static_cast<std::size_t>(i)] = map::Voxel::kOccupied;
  }
  map.merge(RobotId{98}, map::said({3, 0, 0}, wall));
  PathFinder fresh(map);
  const auto seen = finder.find_through_unknown(Vec3(1, 1.5, 1.5), Vec3(20, 1.5, 1.5), 0.3);
  const auto anew = fresh.find_through_unknown(Vec3(1, 1.5, 1.5), Vec3(20, 1.5, 1.5), 0.3);
  REQUIRE(seen.path.has_value() == anew.path.has_value());
  if (seen.path) CHECK(seen.path->points == anew.path->points);
  REQUIRE(seen.path);
  for (const Vec3& p : seen.path->points) CHECK_FALSE(map.blocked(map.key(p)));
}

TEST_CASE("a search gives up at its limit and says so") {
  KnownMap hall({0, 0, 0}, {60, 60, 20});
  for (int y = 0; y < 55; ++y) {
    for (int z = 0; z < 20; ++z) hall.occupy({30, y, z});
  }
  PathFinder finder(hall.map(), 50);
  CHECK(finder.find(Vec3(1, 1, 2), Vec3(11, 1, 2)).reason == "search limit");
}

TEST_CASE("equal questions have equal answers") {
  Random random(5, RobotId{0}, "rooms");
  const map::VoxelKey size{60, 60, 20};
  auto rooms = random_rooms(random, size, 60);
  const auto voxels = traversable_voxels(rooms.map(), size);
  PathFinder a(rooms.map()), b(rooms.map());
  for (int i = 0; i < 20; ++i) {
    const Vec3 from = rooms.map().center(voxels[random.below(voxels.size())]);
    const Vec3 to = rooms.map().center(voxels[random.below(voxels.size())]);
    const auto one = a.find(from, to);
    b.flood(to);
    const auto two = b.find(from, to), three = a.find(from, to);
    REQUIRE(one.path.has_value() == two.path.has_value());
    if (one.path) {
      CHECK(one.path->points == two.path->points);
      CHECK(one.path->points == three.path->points);
    }
  }
}

TEST_CASE("costs of searching", "[.cost]") {
  Random random(7, RobotId{0}, "cost");
  const map::VoxelKey size{100, 100, 75};
  auto rooms = random_rooms(random, size, 250);
  const auto& map = rooms.map();
  const auto voxels = traversable_voxels(map, size);
  PathFinder finder(map);
  const Vec3 from = map.center(voxels[voxels.size() / 3]);
  finder.flood(from);
  auto t = std::clock();
  std::size_t reached = 0;
  finder.reached(map.center(map::VoxelKey{5, 5, 5}));
  const Vec3 far = map.center(voxels.back());
  finder.reached(far);
  const double flooded = ms_since(t);
  t = std::clock();
  for (const auto& k : voxels) reached += finder.reached(map.center(k));
  WARN("flood to the farthest corner " << flooded << " ms; " << reached << " of " << voxels.size()
                                       << " voxels reached, asking each " << ms_since(t) << " ms");
  double worst = 0, sum = 0, metres = 0;
  int found = 0;
  for (int i = 0; i < 50; ++i) {
    const Vec3 a = map.center(voxels[random.below(voxels.size())]);
    const Vec3 b = map.center(voxels[random.below(voxels.size())]);
    t = std::clock();
    const auto result = finder.find(a, b);
    const double took = ms_since(t);
    if (!result.path) continue;
    ++found;
    worst = std::max(worst, took);
    sum += took;
    metres += result.path->length_m();
  }
  WARN("A*: mean " << sum / found << " ms, worst " << worst << " ms, mean length " << metres / found
                   << " m");
  KnownMap open({0, 0, 0}, {170, 30, 20});
  PathFinder straight(open.map());
  t = std::clock();
  const bool ok = straight.find(Vec3(1, 1, 1), Vec3(31, 4, 3)).path.has_value();
  WARN("A* 30 m in the open: " << ms_since(t) << " ms, found " << ok);
}
