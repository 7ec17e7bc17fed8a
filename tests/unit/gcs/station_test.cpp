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

TEST_CASE("a station that starts again and kept nothing assigns nothing before it heard anybody") {
  const mission::Mission m = robot::small_mission();
  robot::Knowledge station(m, RobotId{0}, 2), explorer(m, RobotId{1}, 1);
  gcs::Slei3dStation strategy(m, RobotId{0});
  const auto decide = [&](double t_s) {
    station.begin(SimTime::from_s(t_s));
    explorer.begin(SimTime::from_s(t_s));
    mission::Odometry o;
    o.pose = m.robot(RobotId{0}).start;
    station.observe(o);
    return strategy.decide(station, {});
  };
  const auto assigned = [&] { return station.plan(RobotId{0}, mission::PlanKind::kAssignment); };
  const robot::Intent alone = decide(500);
  CHECK_FALSE(assigned());
  CHECK(alone.kind == robot::Intent::Kind::kGo);  // to where it can be met
  robot::hear(station, explorer);
  decide(501);
  CHECK_FALSE(assigned());
  station.exchange().on_beacon(RobotId{1}, 1, 1, {}, station.now());  // it has nothing to say
  decide(501);
  CHECK(assigned());
}
