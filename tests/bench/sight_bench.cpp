// Who sees whom among 75 robots in a site of 70 000 triangles: the radio's rays through the mesh
// (Embree) against OctoMap's castRay through the same surfaces, in voxels of as many centimetres as
// the benchmark's name says.
//
//     build/tests/bench_sight        look at the counter times_faster: 20 is the aim
#include <benchmark/benchmark.h>
#include <octomap/octomap.h>

#include <cmath>
#include <ctime>
#include <numbers>
#include <vector>

#include "common/core/random.h"
#include "commsim/world/scene.h"

namespace {

using namespace muster;
using world::Mesh;

constexpr double kSize_m = 120;
constexpr int kRobots = 75;

double ground_m(double x, double y) {
  return 1.5 * std::sin(0.11 * x) * std::cos(0.07 * y) + 0.4 * std::sin(0.9 * x + 0.5 * y);
}

/// A net of (columns + 1) × (rows + 1) points, two triangles a cell.
template <class Point>
void add_net(Mesh& mesh, int columns, int rows, const Point& point) {
  const int first = static_cast<int>(mesh.vertices.size());
  for (int i = 0; i <= columns; ++i) {
    for (int j = 0; j <= rows; ++j) mesh.vertices.push_back(point(i, j).template cast<float>());
  }
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const int a = first + i * (rows + 1) + j, b = a + rows + 1;
      mesh.triangles.emplace_back(a, b, b + 1);
      mesh.triangles.emplace_back(a, b + 1, a + 1);
    }
  }
}

/// Hills, and a hundred domes and towers on them.
Mesh site() {
  Mesh mesh;
  constexpr int kCells = 150;
  add_net(mesh, kCells, kCells, [](int i, int j) {
    const double x = i * kSize_m / kCells, y = j * kSize_m / kCells;
    return Vec3(x, y, ground_m(x, y));
  });
  Random random(1, kNoRobot, "domes");
  for (int dome = 0; dome < 100; ++dome) {
    const double x = random.uniform(4, kSize_m - 4), y = random.uniform(4, kSize_m - 4);
    const double radius_m = random.uniform(1, 3), height_m = random.uniform(3, 12);
    add_net(mesh, 20, 6, [&](int i, int j) {
      const double around = 2 * std::numbers::pi * i / 20, up = std::numbers::pi / 2 * j / 6;
      return Vec3(x + radius_m * std::cos(up) * std::cos(around),
                  y + radius_m * std::cos(up) * std::sin(around),
                  ground_m(x, y) + height_m * std::sin(up));
    });
  }
  return mesh;
}

/// Every voxel that a surface touches, by points on it closer than half a voxel.
octomap::OcTree voxels_of(const Mesh& mesh, double voxel_m) {
  octomap::OcTree tree(voxel_m);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto corner = [&](int i) {
      return mesh.vertices[static_cast<std::size_t>(t[i])].cast<double>().eval();
    };
    const Vec3 a = corner(0), ab = corner(1) - a, ac = corner(2) - a;
    const int n = 1 + static_cast<int>(2 * std::max(ab.norm(), ac.norm()) / voxel_m);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        const Vec3 p = a + ab * i / n + ac * j / n;
        tree.updateNode(octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()),
                                         static_cast<float>(p.z())),
                        true, true);
      }
    }
  }
  tree.updateInnerOccupancy();
  return tree;
}

std::vector<Vec3> robots() {
  Random random(2, kNoRobot, "robots");
  std::vector<Vec3> all;
  for (int i = 0; i < kRobots; ++i) {
    const double x = random.uniform(2, kSize_m - 2), y = random.uniform(2, kSize_m - 2);
    all.emplace_back(x, y, ground_m(x, y) + random.uniform(1, 6));
  }
  return all;
}

bool sees(const octomap::OcTree& tree, const Vec3& a, const Vec3& b) {
  const Vec3 way = b - a;
  const octomap::point3d from(static_cast<float>(a.x()), static_cast<float>(a.y()),
                              static_cast<float>(a.z()));
  const octomap::point3d direction(static_cast<float>(way.x()), static_cast<float>(way.y()),
                                   static_cast<float>(way.z()));
  octomap::point3d end;
  return !tree.castRay(from, direction, end, true, way.norm());
}

/// Every pair once; how many see each other, and what it took.
template <class Sees>
std::pair<std::vector<bool>, double> all_pairs_ms(const std::vector<Vec3>& places,
                                                  const Sees& line_of_sight) {
  std::vector<bool> seen;
  const std::clock_t begin = std::clock();
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = i + 1; j < places.size(); ++j) {
      seen.push_back(line_of_sight(places[i], places[j]));
    }
  }
  return {seen, 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC};
}

void line_of_sight_of_all_pairs(benchmark::State& bench) {
  const world::Scene scene(site());
  const octomap::OcTree tree = voxels_of(scene.mesh(), static_cast<double>(bench.range(0)) / 100);
  const std::vector<Vec3> places = robots();
  double embree_ms = 0, octomap_ms = 0, agree = 0;
  std::size_t pairs = 0;
  for (auto _ : bench) {
    const auto [by_mesh, mesh_ms] = all_pairs_ms(
        places, [&](const Vec3& a, const Vec3& b) { return scene.line_of_sight(a, b); });
    const auto [by_voxels, voxels_ms] =
        all_pairs_ms(places, [&](const Vec3& a, const Vec3& b) { return sees(tree, a, b); });
    embree_ms += mesh_ms;
    octomap_ms += voxels_ms;
    for (std::size_t i = 0; i < by_mesh.size(); ++i) agree += by_mesh[i] == by_voxels[i];
    pairs += by_mesh.size();
  }
  const double n = static_cast<double>(bench.iterations());
  bench.counters["triangles"] = static_cast<double>(scene.mesh().triangles.size());
  bench.counters["pairs"] = static_cast<double>(pairs) / n;
  bench.counters["embree_ms"] = embree_ms / n;
  bench.counters["octomap_ms"] = octomap_ms / n;
  bench.counters["times_faster"] = octomap_ms / embree_ms;
  bench.counters["agree"] = agree / static_cast<double>(pairs);
}

BENCHMARK(line_of_sight_of_all_pairs)->Arg(20)->Arg(10)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
