#include "common/robot/guardian.h"

#include <catch2/catch.hpp>

#include "tests/unit/robot/fixtures.h"

using namespace muster;
using robot::Guardian;
using robot::Intent;
using robot::Knowledge;

namespace {

void request(Knowledge& k, mission::RequestVerb verb, RobotId whom, std::uint64_t n) {
  mission::Status s;
  s.kind = mission::StatusKind::kRequest;
  s.request = verb;
  s.robot = whom;
  s.request_n = n;
  k.publish(store::RecordClass::kRequest, robot::request_key(n), s);
}

}  // namespace

TEST_CASE("a request heard through a third robot is obeyed, the newest one that concerns me") {
  const mission::Mission m = robot::small_mission();
  Knowledge station(m, RobotId{0}, 1), explorer(m, RobotId{1}, 1), inspector(m, RobotId{2}, 1);
  Guardian guardian;
  CHECK_FALSE(guardian.overrule(inspector));
  request(station, mission::RequestVerb::kHold, kNoRobot, 1);
  robot::pass(station, explorer, store::RecordClass::kRequest);
  robot::pass(explorer, inspector, store::RecordClass::kRequest);
  REQUIRE(guardian.overrule(inspector));
  CHECK(guardian.overrule(inspector)->activity == mission::Activity::kHolding);
  request(station, mission::RequestVerb::kAbort, RobotId{1}, 2);  // not for me
  robot::pass(station, inspector, store::RecordClass::kRequest);
  CHECK(guardian.overrule(inspector)->activity == mission::Activity::kHolding);
  request(station, mission::RequestVerb::kResume, kNoRobot, 3);
  robot::pass(station, inspector, store::RecordClass::kRequest);
  CHECK_FALSE(guardian.overrule(inspector));
  request(station, mission::RequestVerb::kAbort, kNoRobot, 4);
  robot::pass(station, inspector, store::RecordClass::kRequest);
  REQUIRE(guardian.overrule(inspector));
  CHECK(guardian.overrule(inspector)->kind == Intent::Kind::kLand);
  CHECK(guardian.overrule(inspector)->goal.p == m.fleet[2].start.p);
}

TEST_CASE("a robot that hears nobody for the mission's limit goes home") {
  mission::Mission m = robot::small_mission();
  m.lost_contact_s = 100;
  Knowledge explorer(m, RobotId{1}, 1), station(m, RobotId{0}, 1);
  Guardian guardian;
  explorer.begin(SimTime::from_s(50));
  robot::hear(explorer, station);
  explorer.begin(SimTime::from_s(149));
  CHECK_FALSE(guardian.overrule(explorer));
  explorer.begin(SimTime::from_s(151));
  REQUIRE(guardian.overrule(explorer));
  CHECK(guardian.overrule(explorer)->kind == Intent::Kind::kLand);
}

TEST_CASE("a battery below its reserve sends home, unless it is charging") {
  mission::Mission m = robot::small_mission();
  m.fleet[1].vehicle.discharge_mah_per_s = 0.5;
  Knowledge explorer(m, RobotId{1}, 1);
  Guardian guardian;
  mission::Battery b;
  b.charge = 0.3f;
  explorer.observe(b);
  CHECK_FALSE(guardian.overrule(explorer));
  b.charge = 0.1f;
  explorer.observe(b);
  CHECK(guardian.overrule(explorer));
  b.charging = true;
  explorer.observe(b);
  CHECK_FALSE(guardian.overrule(explorer));
}
