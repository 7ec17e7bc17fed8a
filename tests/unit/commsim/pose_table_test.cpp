#include "commsim/pose_table.h"

#include <catch2/catch.hpp>

using namespace muster;
using commsim::PoseTable;

namespace {

constexpr RobotId kA{1}, kB{2};

mission::Truth frame(double stamp_s, RobotId robot, double x) {
  mission::Truth truth;
  truth.time = SimTime::from_s(stamp_s);
  truth.robots.push_back({robot, mission::VehicleState::kMoving, {Vec3(x, 0, 1), 0}, Vec3::Zero()});
  return truth;
}

SimTime s(double t) { return SimTime::from_s(t); }

}  // namespace

TEST_CASE("a pose counts for half a second after it came, whatever its stamp") {
  PoseTable poses;
  CHECK_FALSE(poses.at(kA, s(0)));
  poses.hear(frame(-7000, kA, 3), s(1));
  REQUIRE(poses.at(kA, s(1.5)));
  CHECK(poses.at(kA, s(1.5))->p.x() == 3);
  CHECK_FALSE(poses.at(kA, s(1.51)));
  CHECK_FALSE(poses.at(kB, s(1)));
}

TEST_CASE("each robot's pose is as old as the last frame that had it") {
  PoseTable poses;
  poses.hear(frame(1, kA, 3), s(1));
  poses.hear(frame(1.4, kB, 4), s(1.4));
  CHECK_FALSE(poses.at(kA, s(1.6)));
  CHECK(poses.at(kB, s(1.6)));
}

TEST_CASE("what a bridge says again, or late, is no news") {
  PoseTable poses;
  poses.hear(frame(5, kA, 3), s(1));
  poses.hear(frame(5, kA, 3), s(1.4));
  poses.hear(frame(4.9, kA, 2), s(1.45));
  CHECK(poses.at(kA, s(1.5))->p.x() == 3);
  CHECK_FALSE(poses.at(kA, s(1.6)));
}

TEST_CASE("a motion capture that was started again is believed once the old pose has run out") {
  PoseTable poses;
  poses.hear(frame(500, kA, 3), s(1));
  poses.hear(frame(0.1, kA, 4), s(1.4));
  CHECK(poses.at(kA, s(1.4))->p.x() == 3);
  poses.hear(frame(0.3, kA, 5), s(1.6));
  CHECK(poses.at(kA, s(1.6))->p.x() == 5);
}
