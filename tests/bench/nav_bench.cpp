// What finding ways costs, beside the textbook's way of doing the same: transit through unknown
// space against A* with the distance as its estimate, a flood against Dijkstra over all 26 steps.
//
//     build/tests/bench_nav
#include <benchmark/benchmark.h>

#include <map>
#include <queue>
#include <vector>

#include "common/core/random.h"
#include "common/nav/flood.h"
#include "common/nav/path_finder.h"
#include "common/nav/search.h"
#include "tests/unit/nav/known_map.h"

namespace {

using namespace muster;
using namespace muster::nav;
using muster::test::below;

/// 20 × 20 × 10 m with pillars and slabs, known; unknown around, 120 m wide.
map::VoxelMap& site() {
  static test::KnownMap known = [] {
    map::MapConfig config;
    config.bounds = Box::from_corners(Vec3(-30, -30, 0), Vec3(90, 60, 20));
    test::KnownMap rooms({0, 0, 0}, {100, 100, 50}, config);
    Random random(7, RobotId{0}, "bench");
    for (int i = 0; i < 120; ++i) {
      const map::VoxelKey at{below(random, 100), below(random, 100), below(random, 50)};
      const bool pillar = random.chance(0.5);
      for (int a = 0; a < (pillar ? 2 : 14); ++a) {
        for (int b = 0; b < (pillar ? 2 : 14); ++b) {
          for (int z = pillar ? 0 : at.z; z < (pillar ? 50 : at.z + 1); ++z) {
            if (at.x + a < 100 && at.y + b < 100) rooms.occupy({at.x + a, at.y + b, z});
          }
        }
      }
    }
    return rooms;
  }();
  return known.map();
}

Vec3 open_place() {
  for (int i = 15; i < 85; ++i) {
    const Vec3 p(0.2 * i, 10, 2);
    if (site().traversable(p)) return p;
  }
  return {10, 10, 2};
}

constexpr int kCost[4] = {0, 10, 14, 17};

/// Costs (tenths of a voxel) to `goal`, or to everything; `estimate`: the distance as A* counts it.
std::size_t textbook(const map::VoxelMap& map, map::VoxelKey from, const map::VoxelKey* goal,
                     bool unknown, std::size_t limit) {
  const auto open = [&](map::VoxelKey k) {
    return map.traversable(k) || (unknown && !map.blocked(k));
  };
  const auto estimate = [&](map::VoxelKey k) {
    if (!goal) return 0;
    const Vec3 d(k.x - goal->x, k.y - goal->y, k.z - goal->z);
    return static_cast<int>(10 * d.norm());
  };
  std::map<map::VoxelKey, int> cost{{from, 0}};
  std::priority_queue<std::pair<int, map::VoxelKey>, std::vector<std::pair<int, map::VoxelKey>>,
                      std::greater<>>
      queue;
  queue.push({estimate(from), from});
  std::size_t expanded = 0;
  while (!queue.empty() && expanded < limit) {
    const auto [f, k] = queue.top();
    queue.pop();
    const int g = cost.at(k);
    if (f > g + estimate(k)) continue;
    ++expanded;
    if (goal && k == *goal) break;
    for (const Step& s : steps()) {
      if (s.axes == 0) continue;
      bool free = true;
      for (const int x : {0, s.dx}) {
        for (const int y : {0, s.dy}) {
          for (const int z : {0, s.dz}) free = free && open({k.x + x, k.y + y, k.z + z});
        }
      }
      if (!free) continue;
      const map::VoxelKey n{k.x + s.dx, k.y + s.dy, k.z + s.dz};
      const int factor = map.traversable(n) ? 1 : 2;
      const int then = g + kCost[s.axes] * factor;
      const auto known = cost.find(n);
      if (known != cost.end() && known->second <= then) continue;
      cost[n] = then;
      queue.push({then + estimate(n), n});
    }
  }
  return expanded;
}

const Vec3 kFar(38, 22, 4);

void transit(benchmark::State& state) {
  PathFinder finder(site());
  const Vec3 start = open_place();
  double length_m = 0;
  for (auto _ : state) length_m = finder.find_through_unknown(start, kFar, 0.3).path->length_m();
  state.counters["path_m"] = length_m;
}
BENCHMARK(transit)->Unit(benchmark::kMillisecond);

void transit_textbook(benchmark::State& state) {
  const map::VoxelKey from = site().key(open_place()), to = site().key(kFar);
  std::size_t expanded = 0;
  for (auto _ : state) expanded = textbook(site(), from, &to, true, 150'000);
  state.counters["expanded"] = static_cast<double>(expanded);
}
BENCHMARK(transit_textbook)->Unit(benchmark::kMillisecond)->Iterations(1);

void flood(benchmark::State& state) {
  Grid grid(site());
  Flood flood(grid);
  const Cell from = grid.cell(site().key(open_place()));
  Cell corner = grid.cell({97, 97, 47});  // far enough to ask for nearly all
  while (!grid.traversable(corner)) --corner.x;
  for (auto _ : state) {
    flood.start(from, 1e9);
    benchmark::DoNotOptimize(flood.distance_m(corner));
  }
}
BENCHMARK(flood)->Unit(benchmark::kMillisecond);

void flood_textbook(benchmark::State& state) {
  std::size_t expanded = 0;
  for (auto _ : state)
    expanded = textbook(site(), site().key(open_place()), nullptr, false, 10'000'000);
  state.counters["expanded"] = static_cast<double>(expanded);
}
BENCHMARK(flood_textbook)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace

BENCHMARK_MAIN();
