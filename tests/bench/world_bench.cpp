// The world's cost per robot and simulated second: vehicles, scans, sightings, contacts, refereeing
// (DESIGN "Budget": 4 ms).
//
//     build/tests/bench_world        look at the counter ms_per_robot_s
#include <benchmark/benchmark.h>

#include <cmath>
#include <ctime>

#include "tests/unit/world/fixtures.h"

namespace {

using namespace muster;
using namespace muster::world;
using namespace muster::world::testing;

/// A grid of houses, streets between them.
Mesh streets() {
  Mesh mesh = ground();
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      add_solid(mesh, {i * 7.0 - 2, j * 7.0 - 2, 0}, {i * 7.0 + 2, j * 7.0 + 2, 5});
    }
  }
  return mesh;
}

/// 1 station, n/3 explorers, the rest inspectors, all in the streets.
mission::Mission fleet(std::uint32_t n) {
  std::vector<mission::RobotConfig> robots = {rover(0, {-10.5, -10.5, 0.4})};
  for (std::uint32_t i = 1; i < n; ++i) {
    const Vec3 p(-10.5 + 7.0 * (i % 4), -10.5 + 7.0 * (i / 4 % 4), 2.0 + i / 16);
    robots.push_back(
        robot(i, i <= n / 3 ? mission::Role::kExplorer : mission::Role::kInspector, p));
  }
  return mission_of(std::move(robots));
}

FeatureSet spots() {
  FeatureSet set;
  for (std::uint32_t i = 0; i < 150; ++i) {
    const double a = 0.3 * i;
    set.features.push_back(
        feature(i, {-16 + 0.2 * i, 2 + 0.01 * i, 1 + 0.02 * i}, {std::cos(a), std::sin(a), 0}));
  }
  return set;
}

/// Up and down the streets for ever, turning on the way.
mission::Trajectory patrol(const Vec3& start, double t_s) {
  mission::Trajectory t;
  t.states = {state(t_s, start), state(t_s + 4, start + Vec3(0, 4, 0), {0, 0, 0}, 2),
              state(t_s + 8, start, {0, 0, 0}, 0)};
  return t;
}

void world_second(benchmark::State& bench) {
  const auto robots = static_cast<std::uint32_t>(bench.range(0));
  const mission::Mission m = fleet(robots);
  World world(m, scene_of(streets()), spots(), {});
  std::uint64_t k = 0;
  const std::clock_t begin = std::clock();
  for (auto _ : bench) {
    for (int i = 0; i < 10; ++i, ++k) {
      benchmark::DoNotOptimize(world.begin_tick(k));
      std::vector<mission::Message> commands;
      if (k % 80 == 0) {
        for (std::uint32_t r = 1; r < robots; ++r) {
          commands.push_back(from(r, patrol(m.fleet[r].start.p, time_of_tick(k).s())));
        }
      }
      world.end_tick(k, commands);
      benchmark::DoNotOptimize(world.trace());
    }
  }
  const double ms = 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  bench.counters["ms_per_robot_s"] = ms / static_cast<double>(bench.iterations()) / robots;
}
BENCHMARK(world_second)->Arg(7)->Arg(13)->Arg(49)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
