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
