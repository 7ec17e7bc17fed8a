#include <catch2/catch.hpp>

#include "agent/strategy/slei3d_explorer.h"
#include "tests/unit/agent/place.h"

using namespace muster;
using namespace muster::agent;

namespace {

constexpr RobotId kStation{0}, kSelf{1};

/// An explorer that was started again at 100 s, with nothing of what it knew.
struct Blank {
  mission::Mission mission = robot::small_mission();
  robot::Knowledge station{mission, kStation, 1}, k{mission, kSelf, 2};
  Slei3dExplorer explorer{mission, kSelf};

  robot::Intent at(double t_s) {
    station.begin(SimTime::from_s(t_s));
    be_at(k, t_s, {5, 3, 1.2});
    return explorer.decide(k, {});
  }
  void hear_orders() {
    mission::Plan plan;
    plan.kind = mission::PlanKind::kAssignment;
    plan.allocations = {{kSelf, kNoRobot, RegionId{0}, {}}};
    station.publish(store::RecordClass::kPlan, robot::plan_key(plan.kind), plan);
    robot::pass(station, k, store::RecordClass::kPlan);
  }
  bool to_standing_place(const robot::Intent& intent) const {
    return intent.kind == robot::Intent::Kind::kGo &&
           (intent.goal.p - mission.standing.place).head<2>().norm() < 0.01;
  }
};

}  // namespace

TEST_CASE("an explorer without orders looks for the station at the standing place") {
  Blank b;
  CHECK(b.at(100).kind == robot::Intent::Kind::kHover);
  CHECK(b.at(119).kind == robot::Intent::Kind::kHover);
  const robot::Intent intent = b.at(121);
  CHECK(b.to_standing_place(intent));
  CHECK(intent.activity == mission::Activity::kWaiting);
  robot::hear(b.k, b.station);  // there it is: its word will come
  CHECK(b.at(122).kind == robot::Intent::Kind::kHover);
}

TEST_CASE("an explorer with orders that agreed on no meeting leaves for the next standing rung") {
  Blank b;
  b.at(100);
  b.hear_orders();  // from somebody who passed
  CHECK_FALSE(b.to_standing_place(b.at(155)));
  CHECK_FALSE(b.to_standing_place(b.at(200)));  // works on until it is time
  const robot::Intent intent = b.at(295);
  CHECK(b.to_standing_place(intent));
  CHECK(intent.activity == mission::Activity::kMeeting);
}

TEST_CASE("an explorer that starts again with its looks goes on with what it sighted, each once") {
  Blank b;
  mission::Sightings look;
  look.sensor.p = {5, -3, 2};
  look.seen = {{{5, 0, 2}, 0, 0, 0}};
  b.at(100);
  b.explorer.on_sightings(b.k, look);
  b.hear_orders();
  b.at(101);
  b.explorer.on_sightings(b.k, look);
  REQUIRE(b.k.looks().size() == 2);
  CHECK(b.k.looks()[0].explored == kNoRegion);
  CHECK(b.k.looks()[1].explored == RegionId{0});
  REQUIRE(b.k.areas().size() == 1);

  robot::Knowledge again(b.mission, kSelf, 3);
  for (const auto& [explored, sightings] : b.k.looks()) again.keep_look(explored, sightings);
  robot::pass(b.k, again, store::RecordClass::kArea);
  robot::pass(b.station, again, store::RecordClass::kPlan);
  Slei3dExplorer explorer(b.mission, kSelf);
  be_at(again, 200, {5, 3, 1.2});
  explorer.on_sightings(again, look);  // before it follows any orders
  explorer.decide(again, {});
  explorer.on_sightings(again, look);
  REQUIRE(again.areas().size() == 1);
  CHECK(again.areas().begin()->second.area.sightings == 2);
}
