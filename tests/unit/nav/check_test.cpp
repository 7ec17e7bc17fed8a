#include <catch2/catch.hpp>

#include "common/map/voxel_map.h"
#include "common/nav/trajectory.h"
#include "tests/unit/nav/known_map.h"

using namespace muster;
using namespace muster::nav;
using muster::test::KnownMap;

namespace {

Trajectory straight(const Vec3& from, const Vec3& to) {
  TimingRequest request;
  request.now.p = from;
  request.now.yaw_rad = std::atan2(to.y() - from.y(), to.x() - from.x());
  return time_path(Path{{from, to}}, request, {});
}

constexpr double kRadius = 0.25;

}  // namespace

TEST_CASE("a clear way is safe and a wall one voxel thick is seen at any speed") {
  KnownMap clear({0, 0, 0}, {50, 20, 20});
  const auto flight = straight(Vec3(1, 2, 2), Vec3(9, 2, 2));
  CHECK_FALSE(check(flight, flight.start(), clear.map(), kRadius, {}, {}));

  KnownMap walled({0, 0, 0}, {50, 20, 20});
  for (int y = 0; y < 20; ++y) {
    for (int z = 0; z < 20; ++z) walled.occupy({30, y, z});
  }
  const auto hit = check(flight, flight.start(), walled.map(), kRadius, {}, {});
  REQUIRE(hit);
  CHECK(hit->with == "map");
  CHECK(hit->p.x() < 6.0);
  CHECK(hit->p.x() > 5.6);
}

TEST_CASE("unknown space is not free") {
  KnownMap half({0, 0, 0}, {25, 20, 20});
  const auto flight = straight(Vec3(1, 2, 2), Vec3(9, 2, 2));
  const auto hit = check(flight, flight.start(), half.map(), kRadius, {}, {});
  REQUIRE(hit);
  CHECK(hit->p.x() < 5.0);
}

TEST_CASE("a body that stands within clearance, even in contact, may leave but not go deeper") {
  KnownMap walled({0, 0, 0}, {50, 20, 20});
  for (int y = 0; y < 20; ++y) {
    for (int z = 0; z < 20; ++z) walled.occupy({30, y, z});
  }
  const Vec3 near(5.85, 2, 2);  // 0.15 m from the wall
  const auto away = straight(near, Vec3(3, 2, 2)), deeper = straight(near, Vec3(6, 2, 2));
  CHECK_FALSE(check(away, away.start(), walled.map(), kRadius, {}, {}));
  CHECK(check(deeper, deeper.start(), walled.map(), kRadius, {}, {}));
  const auto along =
      straight(Vec3(5.7, 2, 2), Vec3(5.7, 3, 2));  // within clearance, not in contact
  CHECK_FALSE(check(along, along.start(), walled.map(), kRadius, {}, {}));
}

TEST_CASE("a crossing robot is seen when it is there at the same time, and only then") {
  KnownMap clear({0, 0, 0}, {60, 60, 20});
  const auto flight = straight(Vec3(1, 5, 2), Vec3(9, 5, 2));
  const auto crossing = [&](double delay_s) {
    Mover mover;
    mover.robot = RobotId{7};
    State a, b;
    a.t = SimTime::from_s(delay_s);
    a.p = Vec3(5, 2, 2);
    b.t = SimTime::from_s(delay_s + 5);
    b.p = Vec3(5, 8, 2);
    mover.announced = {a, b};
    return std::vector<Mover>{mover};
  };
  const auto hit = check(flight, flight.start(), clear.map(), kRadius, crossing(0), {});
  REQUIRE(hit);
  CHECK(hit->with == "robot 7");
  CHECK(hit->robot == RobotId{7});
  CHECK_FALSE(check(flight, flight.start(), clear.map(), kRadius, crossing(4), {}));
}

TEST_CASE("a robot that hovers too near may be left, not approached") {
  KnownMap clear({0, 0, 0}, {60, 60, 20});
  Mover mover;
  mover.robot = RobotId{2};
  State there;
  there.p = Vec3(5.5, 5, 2);
  mover.announced = {there};
  const std::vector<Mover> movers{mover};
  const Vec3 here(5, 5, 2);
  const auto away = straight(here, Vec3(3, 5, 2)), towards = straight(here, Vec3(7, 5, 2));
  CHECK_FALSE(check(away, away.start(), clear.map(), kRadius, movers, {}));
  CHECK(check(towards, towards.start(), clear.map(), kRadius, movers, {}));
  const auto hover = stop(away.at(away.start()), {});
  CHECK_FALSE(check(hover, hover.start(), clear.map(), kRadius, movers, {}));
}

TEST_CASE("a short-lived obstacle blocks, and the place of arrival must stay free for a while") {
  KnownMap clear({0, 0, 0}, {60, 60, 20});
  const auto flight = straight(Vec3(1, 5, 2), Vec3(5, 5, 2));
  const std::vector<map::Sphere> obstacle{{Vec3(3, 5.4, 2), 0.2}};
  const auto hit = check(flight, flight.start(), clear.map(), kRadius, {}, obstacle);
  REQUIRE(hit);
  CHECK(hit->with == "obstacle");

  Mover late;
  late.robot = RobotId{3};
  State a, b;
  a.t = flight.end();
  a.p = Vec3(5, 8, 2);
  b.t = flight.end() + Duration::from_s(1.5);
  b.p = Vec3(5, 5, 2);
  late.announced = {a, b};
  CHECK(check(flight, flight.start(), clear.map(), kRadius, std::vector<Mover>{late}, {}));
}

TEST_CASE("only what is still to be flown is checked") {
  KnownMap walled({0, 0, 0}, {50, 20, 20});
  for (int y = 0; y < 20; ++y) {
    for (int z = 0; z < 20; ++z) walled.occupy({15, y, z});
  }
  const auto flight = straight(Vec3(1, 2, 2), Vec3(9, 2, 2));
  CHECK(check(flight, flight.start(), walled.map(), kRadius, {}, {}));
  CHECK_FALSE(check(flight, SimTime::from_s(3.5), walled.map(), kRadius, {}, {}));
}
