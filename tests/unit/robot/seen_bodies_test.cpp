#include "common/robot/seen_bodies.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "tests/unit/nav/known_map.h"
#include "tests/unit/robot/fixtures.h"

using namespace muster;
using robot::SeenBodies;

namespace {

/// One scan of a camera at the origin of height 1.5 m that looks along x.
map::RangeScan scan() {
  map::RangeScan s;
  s.sensor = {{0, 0, 1.5}, 0};
  s.range_m = 5;
  s.hfov_rad = std::numbers::pi / 2;
  s.vfov_rad = std::numbers::pi / 3;
  return s;
}

}  // namespace

TEST_CASE("a body that is seen is an obstacle for a while") {
  SeenBodies bodies;
  bodies.see(SimTime::from_s(1), {{3, 0, 1.5}, {3.1, 0, 1.5}, {3, 2, 1.5}});
  bodies.forget(SimTime::from_s(2));
  CHECK(bodies.spheres().size() == 2);  // returns beside each other are one
  bodies.see(SimTime::from_s(4), {{3, 2, 1.5}});
  bodies.forget(SimTime::from_s(17));
  REQUIRE(bodies.spheres().size() == 1);
  CHECK(bodies.spheres()[0].center.isApprox(Vec3(3, 2, 1.5)));
  bodies.forget(SimTime::from_s(20));
  CHECK(bodies.spheres().empty());
}

TEST_CASE("a body is gone where a scan sees through its place, and only there") {
  const mission::Mission m = robot::small_mission();
  robot::Knowledge k(m, RobotId{1}, 1);
  const Vec3 ahead(2, 0, 1.5), behind(-2, 0, 1.5), far(7, 0, 1.5);
  for (const bool still_seen : {false, true}) {
    SeenBodies bodies;
    bodies.see(SimTime::from_s(1), {ahead, behind, far});
    std::vector<Vec3> seen;
    if (still_seen) seen.emplace_back(2.1, 0.1, 1.5);
    bodies.see_through(k.map(), scan(), seen);
    bodies.forget(SimTime::from_s(1));
    CHECK(bodies.spheres().size() == (still_seen ? 3 : 2));
  }
}

TEST_CASE("a body is in the air when there is room below it, and as long as it is seen") {
  test::KnownMap known({0, -5, 0}, {20, 5, 20});
  for (int x = 0; x < 20; ++x) {
    for (int y = -5; y < 5; ++y) known.occupy({x, y, -1});
  }
  SeenBodies bodies;
  const map::Sphere here{{0, 0, 2}, 3};
  bodies.see(SimTime::from_s(1), {{1, 0, 0.5}});
  CHECK_FALSE(bodies.in_the_air(known.map(), here, SimTime::from_s(1)));  // it stands
  bodies.see(SimTime::from_s(1), {{-1, 0, 2}});
  CHECK_FALSE(bodies.in_the_air(known.map(), here, SimTime::from_s(1)));  // on what nobody knows
  bodies.see(SimTime::from_s(1), {{1, 0, 2}});
  CHECK(bodies.in_the_air(known.map(), here, SimTime::from_s(1.5)));
  CHECK_FALSE(bodies.in_the_air(known.map(), {{0, 0, 2}, 0.9}, SimTime::from_s(1.5)));  // far away
  CHECK_FALSE(bodies.in_the_air(known.map(), here, SimTime::from_s(3)));
}

TEST_CASE("what stands below a landing place takes it") {
  SeenBodies bodies;
  bodies.see(SimTime::from_s(1), {{3, 0, 0.2}});
  CHECK(bodies.below({3.3, 0, 2}, 0.25));
  CHECK_FALSE(bodies.below({3.8, 0, 2}, 0.25));
  CHECK_FALSE(bodies.below({3, 0, -0.5}, 0.25));
}
