#include "common/robot/lookout.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "tests/unit/nav/known_map.h"

using namespace muster;

namespace {

constexpr double kRadius_m = 0.25;

/// A camera at `eye` that looks along x.
map::RangeScan scan(const Vec3& eye) {
  map::RangeScan s;
  s.sensor = {eye, 0};
  s.range_m = 5;
  s.hfov_rad = std::numbers::pi / 2;
  s.vfov_rad = std::numbers::pi / 3;
  return s;
}

nav::Path along_x(double z) { return {{{0.1, 0.1, z}, {4.1, 0.1, z}}}; }

/// Free above a floor whose top is at 0, 10 m long and 4 m wide.
test::KnownMap room() {
  test::KnownMap known({-5, -10, -1}, {45, 10, 20});
  for (int x = -5; x < 45; ++x) {
    for (int y = -10; y < 10; ++y) known.occupy({x, y, -1});
  }
  return known;
}

}  // namespace

TEST_CASE("somebody may stand on the floor where the camera has not looked for a minute") {
  test::KnownMap known = room();
  robot::Lookout lookout;
  const nav::Path low = along_x(0.6);
  const SimTime now = SimTime::from_s(100);
  CHECK_FALSE(lookout.clear(low, known.map(), now, kRadius_m));
  lookout.looked(now, scan({0.1, 0.1, 0.6}));
  CHECK(lookout.clear(low, known.map(), SimTime::from_s(130), kRadius_m));
  CHECK_FALSE(lookout.clear(low, known.map(), SimTime::from_s(170), kRadius_m));
  CHECK_FALSE(lookout.clear(nav::Path{{{0.1, 0.1, 0.6}, {-0.9, 0.1, 0.6}}}, known.map(), now,
                            kRadius_m));  // behind the camera
}

TEST_CASE("what a wall hides from the camera has not been looked at") {
  test::KnownMap known = room();
  for (int z = 0; z < 20; ++z) {
    for (int y = -10; y < 0; ++y) known.occupy({8, y, z});
  }
  robot::Lookout lookout;
  const SimTime now = SimTime::from_s(100);
  lookout.looked(now, scan({0.1, -1.1, 0.6}));
  CHECK_FALSE(lookout.clear(along_x(0.6), known.map(), now, kRadius_m));
}

TEST_CASE("nobody stands in the air or on a wall that goes up") {
  test::KnownMap known = room();
  const robot::Lookout lookout;
  const SimTime now = SimTime::from_s(100);
  CHECK(lookout.clear(along_x(1.3), known.map(), now, kRadius_m));
  for (int z = 0; z < 20; ++z) {
    for (int x = -5; x < 45; ++x) known.occupy({x, 2, z});  // 0.4 m beside the way
  }
  CHECK(lookout.clear(along_x(1.3), known.map(), now, kRadius_m));
  for (int z = 5; z < 20; ++z) {
    for (int x = 10; x < 12; ++x) known.set({x, 2, z}, map::Voxel::kFree);
  }
  CHECK_FALSE(lookout.clear(along_x(1.3), known.map(), now, kRadius_m));  // a sill
}

TEST_CASE("something may stand on what is unknown") {
  test::KnownMap known({-5, -10, 0}, {45, 10, 20});
  const robot::Lookout lookout;
  CHECK_FALSE(lookout.clear(along_x(0.6), known.map(), SimTime::from_s(1), kRadius_m));
  CHECK(lookout.clear(along_x(1.5), known.map(), SimTime::from_s(1), kRadius_m));
}
