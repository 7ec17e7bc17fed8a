#include <catch2/catch.hpp>

#include "common/core/error.h"
#include "tests/unit/map/said.h"
#include "tests/unit/map/toy_world.h"

using namespace muster;
using namespace muster::map;

namespace {

MapConfig small() {
  MapConfig c;
  c.bounds = Box::from_corners({-5, -5, -1}, {5, 5, 3});
  return c;
}

struct Wanted {
  bool traversable, blocked;
};

double gap(int d) { return d == 0 ? 0 : (std::abs(d) - 0.5) * 0.2; }

/// The definition by brute force: every voxel cube around against the distance from the centre.
Wanted flier(const VoxelMap& m, VoxelKey k) {
  const MapConfig& c = m.config();
  Wanted w{m.at(k) == Voxel::kFree, false};
  for (int z = -4; z <= 4; ++z) {
    for (int y = -4; y <= 4; ++y) {
      for (int x = -4; x <= 4; ++x) {
        const double d = std::hypot(gap(x), gap(y), gap(z)) - 1e-9;
        if (d > c.body_radius_m + c.clearance_m) continue;
        const Voxel v = m.at(VoxelKey{k.x + x, k.y + y, k.z + z});
        if (v == Voxel::kOccupied) w.blocked = true;
        if (v == Voxel::kUnknown && d <= c.body_radius_m) w.traversable = false;
      }
    }
  }
  w.traversable = w.traversable && !w.blocked;
  return w;
}

Wanted driver(const VoxelMap& m, VoxelKey k) {
  const MapConfig& c = m.config();
  if (k.z != 2) return {false, true};  // ride height 0.4 m
  Wanted w{m.at(k) == Voxel::kFree, false};
  for (int y = -4; y <= 4; ++y) {
    for (int x = -4; x <= 4; ++x) {
      const double d = std::hypot(gap(x), gap(y)) - 1e-9;
      for (int z = 1; z <= 3; ++z) {  // 0.2 m … 0.4 + 0.25 + 0.1 m
        const bool occupied = m.at(VoxelKey{k.x + x, k.y + y, z}) == Voxel::kOccupied;
        if (occupied && d <= c.body_radius_m + c.clearance_m) w.blocked = true;
      }
      const bool unknown = m.at(VoxelKey{k.x + x, k.y + y, 2}) == Voxel::kUnknown;
      if (unknown && d <= c.body_radius_m) w.traversable = false;
    }
  }
  w.traversable = w.traversable && !w.blocked;
  return w;
}

template <class Rule>
void check_everywhere(const VoxelMap& m, Rule rule) {
  std::size_t wrong = 0, free = 0;
  toy::for_each_voxel([&](VoxelKey k) {
    if (std::max(std::abs(k.x), std::abs(k.y)) > 26 || k.z > 17) return;
    const Wanted w = rule(m, k);
    const bool outside = !m.config().bounds.contains(m.center(k), 1e-9);
    wrong += m.traversable(k) != (w.traversable && !outside);
    wrong += m.blocked(k) != (w.blocked || outside);
    free += w.traversable;
  });
  CHECK(wrong == 0);
  CHECK(free > 200);
}

const toy::World kYard{
    {{{-10, -10, -1}, {10, 10, 0}}, {{3, -4, 0}, {3.4, 4, 4}}, {{-1, 1.5, 0}, {1, 1.8, 0.7}}}};

void random_updates(VoxelMap& m, std::uint64_t seed) {
  toy::fly_randomly(m, kYard, 3, seed);
  Random random(seed, RobotId{1}, "updates");
  std::vector<Voxel> voxels;
  for (int i = 0; i < 4096; ++i)
    voxels.push_back(random.chance(0.002) ? Voxel::kOccupied : Voxel::kFree);
  const int x = static_cast<int>(random.below(3)) - 1, y = static_cast<int>(random.below(3)) - 1;
  m.merge(RobotId{7}, said({x, y, 0}, voxels));
}

}  // namespace

TEST_CASE("where a flier may be equals brute force after random updates") {
  MapConfig c = small();
  SECTION("small body") {}
  SECTION("large body") {
    c.body_radius_m = 0.45;
    c.clearance_m = 0.15;
  }
  VoxelMap m(c);
  m.insert_free_ball({0, 0, 1.5}, 1.5);
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    random_updates(m, seed);
    check_everywhere(m, flier);
  }
}

TEST_CASE("where a ground vehicle may be equals brute force after random updates") {
  MapConfig c = small();
  c.ground = true;
  VoxelMap m(c);
  m.insert_free_ball({0, 0, 0.4}, 1.5);
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    random_updates(m, seed);
    check_everywhere(m, driver);
  }
}

TEST_CASE("a ground vehicle drives where its flat lidar sees and the ground does not stop it") {
  MapConfig c = small();
  c.ground = true;
  VoxelMap m(c);
  m.insert_free_ball({0, 0, 0.4}, 1.5);
  toy::Sensor lidar;
  lidar.columns = 360;
  lidar.rows = 1;
  lidar.hfov_rad = 2 * std::numbers::pi;
  lidar.vfov_rad = 0;
  lidar.range_m = 8;
  toy::see(m, kYard, {{0, 0, 0.4}, 0.3}, lidar);
  CHECK(m.traversable(Vec3(0, 0, 0.4)));
  CHECK(m.traversable(Vec3(0, 0, 0.39999)));
  CHECK(m.traversable(Vec3(-4, 0, 0.4)));
  CHECK(m.traversable(Vec3(2.3, 0, 0.4)));
  CHECK_FALSE(m.traversable(Vec3(2.9, 0, 0.4)));
  CHECK_FALSE(m.traversable(Vec3(0, 0, 1.2)));
}

TEST_CASE("regress: a flat lidar that looks just over a terrace does not call it free") {
  // As high as the lidar's plane, and told by somebody who flew over it; then the rover's scans, at
  // heights that differ by what a ray in single precision leaves of 0.4 m.
  const toy::World yard{{{{-10, -10, -1}, {10, 10, 0}}, {{1, -3, 0}, {4, 3, 0.36}}}};
  MapConfig c = small();
  c.ground = true;
  toy::Sensor lidar;
  lidar.columns = 360;
  lidar.rows = 1;
  lidar.hfov_rad = 2 * std::numbers::pi;
  lidar.vfov_rad = 0;
  lidar.range_m = 8;
  for (const double z : {0.37, 0.4 - 1e-8, 0.4, 0.4 + 1e-8, 0.43}) {
    VoxelMap m(c);
    m.insert_free_ball({0, 0, 0.4}, 1.5);
    const VoxelKey terrace = m.key({1.5, 0, 0.3});
    std::vector<Voxel> told(kBlockVoxels, Voxel::kUnknown);
    told[static_cast<std::size_t>(local_index(terrace))] = Voxel::kOccupied;
    m.merge(RobotId{9}, said(block_of(terrace), told));
    for (int i = 0; i < 10; ++i) toy::see(m, yard, {{0, 0, z}, 0.01 * i}, lidar, 0.5 * i);
    INFO("lidar at " << z);
    CHECK(m.at(terrace) == Voxel::kOccupied);
    CHECK(m.at(Vec3(1.5, 0, 0.5)) == Voxel::kFree);
    CHECK_FALSE(m.traversable(Vec3(1.3, 0, 0.4)));
    CHECK(m.traversable(Vec3(-1.3, 0, 0.4)));
  }
}

TEST_CASE("a body too large for the voxels is refused") {
  MapConfig c = small();
  c.body_radius_m = 2;
  CHECK_THROWS_AS(VoxelMap(c), BadInput);
}
