#include <catch2/catch.hpp>

#include "gcs/strategy/slei3d_station.h"
#include "tests/unit/robot/fixtures.h"

using namespace muster;

TEST_CASE("a station drives to its parking place itself, not to somebody who stands there") {
  const mission::Mission m = robot::small_mission();
  robot::Knowledge station(m, RobotId{0}, 1);
  gcs::Slei3dStation strategy(m, RobotId{0});
  mission::Odometry o;
  o.pose = m.robot(RobotId{0}).start;
  station.begin(SimTime::from_s(1));
  station.observe(o);
  const robot::Intent intent = strategy.decide(station, {});
  REQUIRE(intent.kind == robot::Intent::Kind::kGo);
  CHECK(intent.with == kNoRobot);  // ways to somebody end before him
}
