#include "common/robot/guardian.h"

#include <algorithm>
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
  for (double t_s = 151; t_s < 151 + 3 * 30; t_s += 1) {
    explorer.begin(SimTime::from_s(t_s));
    if (guardian.overrule(explorer)->kind == Intent::Kind::kLand) break;
  }
  CHECK(guardian.overrule(explorer)->kind == Intent::Kind::kLand);
}

TEST_CASE("who starts in the middle of a mission has been alone only since then") {
  mission::Mission m = robot::small_mission();
  m.lost_contact_s = 100;
  Knowledge inspector(m, RobotId{2}, 2);
  Guardian guardian;
  for (const double t_s : {500.0, 599.0}) {
    inspector.begin(SimTime::from_s(t_s));
    CHECK_FALSE(guardian.overrule(inspector));
  }
  inspector.begin(SimTime::from_s(601));
  CHECK(guardian.overrule(inspector));
}

TEST_CASE("silent robots set out for home one after the other") {
  mission::Mission m = robot::small_mission();
  m.lost_contact_s = 100;
  std::vector<double> set_out_s;
  for (std::uint32_t id = 0; id < 3; ++id) {
    Knowledge k(m, RobotId{id}, 1);
    Guardian guardian;
    for (double t_s = 0; t_s < 250; t_s += 1) {
      k.begin(SimTime::from_s(t_s));
      const auto overruled = guardian.overrule(k);
      if (!overruled || overruled->kind != Intent::Kind::kLand) continue;
      set_out_s.push_back(t_s);
      break;
    }
  }
  REQUIRE(set_out_s.size() == 3);
  std::sort(set_out_s.begin(), set_out_s.end());
  CHECK(set_out_s[1] - set_out_s[0] >= 19);
  CHECK(set_out_s[2] - set_out_s[1] >= 19);
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

TEST_CASE("an explorer that is called home tells its waiting inspector first, but not for ever") {
  const mission::Mission m = robot::small_mission();
  Knowledge explorer(m, RobotId{1}, 1), inspector(m, RobotId{2}, 1);
  const SimTime begin = SimTime::from_s(10);
  inspector.begin(begin);
  explorer.begin(begin);
  mission::Plan route;
  route.kind = mission::PlanKind::kRoute;
  mission::PlanStep end;
  end.at = {SimTime::from_s(40), {{6, 2, 2}, 0}};
  end.action = mission::PlanAction::kWait;
  route.steps.push_back(end);
  inspector.publish(store::RecordClass::kPlan, robot::plan_key(mission::PlanKind::kRoute), route);
  {
    mission::Beacon b;
    b.envelope.src = RobotId{2};
    b.role = mission::Role::kInspector;
    b.epoch = 1;
    explorer.hear(b);
  }
  robot::pass(inspector, explorer, store::RecordClass::kPlan);
  explorer.begin(SimTime::from_s(20));
  request(explorer, mission::RequestVerb::kAbort, kNoRobot, 1);
  Guardian guardian;
  const auto first = guardian.overrule(explorer);
  REQUIRE(first);
  CHECK(first->kind == Intent::Kind::kGo);
  CHECK(first->with == RobotId{2});
  CHECK(first->goal.p == Vec3(6, 2, 2));
  explorer.begin(SimTime::from_s(51));  // 12 s later than it should be there
  CHECK(guardian.overrule(explorer)->kind == Intent::Kind::kGo);
  explorer.begin(SimTime::from_s(53));
  CHECK(guardian.overrule(explorer)->kind == Intent::Kind::kLand);
  // The inspector itself, called home, goes home.
  request(inspector, mission::RequestVerb::kAbort, kNoRobot, 1);
  Guardian other;
  CHECK(other.overrule(inspector)->kind == Intent::Kind::kLand);
}
