#include <catch2/catch.hpp>

#include "agent/strategy/slei3d_inspector.h"
#include "tests/unit/agent/place.h"

using namespace muster;
using namespace muster::agent;
using Kind = robot::Intent::Kind;

namespace {

bool wall(const Vec3& p) { return p.x() > 5.0 && p.x() < 5.4; }

/// An inspector (2) in front of a wall, led by explorer 1.
struct Life {
  mission::Mission mission = robot::small_mission();
  robot::Knowledge station{mission, RobotId{0}, 1}, explorer{mission, RobotId{1}, 1},
      self{mission, RobotId{2}, 1};
  Slei3dInspector inspector;
  robot::Progress progress;

  Life() {
    reveal(self, {-6, -6, 0.1}, {6, 6, 7}, wall);
    time(1);
    mission::Plan plan;
    plan.kind = mission::PlanKind::kAssignment;
    plan.allocations = {{RobotId{2}, RobotId{1}, RegionId{0}, {}}};
    station.publish(store::RecordClass::kPlan, robot::plan_key(plan.kind), plan);
    robot::pass(station, self, store::RecordClass::kPlan);
  }
  void time(double s, const Vec3& p = {2, 0, 2}) {
    be_at(station, s, {-5, 0, 0.5});
    be_at(explorer, s, {1, 0, 2});
    be_at(self, s, p);
  }
  void give(const std::vector<Vec3>& places, std::uint32_t unexplained = 2) {
    mission::Plan plan;
    plan.kind = mission::PlanKind::kAllocation;
    plan.allocations = {{RobotId{2}, RobotId{1}, RegionId{0}, {}}};
    for (const Vec3& p : places) {
      const std::uint64_t key = explorer.store().new_key(store::RecordClass::kArea);
      mission::Area area = area_at(p, p - 2 * Vec3::UnitX());
      area.unexplained = unexplained;
      explorer.publish(store::RecordClass::kArea, key, area);
      plan.allocations.push_back({RobotId{2}, RobotId{1}, RegionId{0}, {RobotId{1}, key}});
    }
    explorer.publish(store::RecordClass::kPlan, robot::plan_key(plan.kind), plan);
    robot::pass(explorer, self, store::RecordClass::kArea);
    robot::pass(explorer, self, store::RecordClass::kPlan);
    robot::hear(self, explorer);
  }
  robot::Intent decide() { return inspector.decide(self, progress); }
  void answer(mission::InspectOutcome outcome) {
    progress.state = robot::Progress::State::kArrived;
    progress.inspected = mission::Inspected{};
    progress.inspected->outcome = outcome;
  }
};

}  // namespace

TEST_CASE("an inspector gathers, inspects what it is given, and waits where its route ends") {
  Life l;
  CHECK(l.decide().goal.p.isApprox(gathering_place(l.mission, RegionId{0}, RobotId{2})));
  l.give({{5, 0, 2}});
  const robot::Intent look = l.decide();
  REQUIRE(look.kind == Kind::kInspect);
  const auto* route = l.self.plan(RobotId{2}, mission::PlanKind::kRoute);
  REQUIRE(route);
  const Vec3 end = route->body.steps.back().at.pose.p;

  l.answer(mission::InspectOutcome::kFound);
  const robot::Intent wait = l.decide();
  CHECK(l.self.results().size() == 1);
  CHECK(wait.kind == Kind::kGo);
  CHECK(wait.goal.p.isApprox(end, 1e-3))  // records carry floats
  ;
}

TEST_CASE("a refused look is followed by one from elsewhere") {
  Life l;
  l.give({{5, 0, 2}});
  const robot::Intent look = l.decide();
  l.answer(mission::InspectOutcome::kRefusedView);
  const robot::Intent again = l.decide();
  REQUIRE(again.kind == Kind::kInspect);
  CHECK((again.goal.p - look.goal.p).norm() > 0.5);
  CHECK(l.self.results().empty());
}

TEST_CASE("a look that is not answered when the hold is over counts as refused") {
  Life l;
  l.give({{5, 0, 2}});
  const robot::Intent look = l.decide();
  l.progress.state = robot::Progress::State::kArrived;
  l.time(5, look.goal.p);
  CHECK(l.decide().goal.p.isApprox(look.goal.p));
  l.time(5 + l.mission.inspect.hold_s, look.goal.p);
  CHECK(l.decide().goal.p.isApprox(look.goal.p));
  l.time(6 + l.mission.inspect.hold_s, look.goal.p);
  const robot::Intent again = l.decide();
  REQUIRE(again.kind == Kind::kInspect);
  CHECK((again.goal.p - look.goal.p).norm() > 0.3);
}

TEST_CASE("beside a known feature, refusals close an area, but not one that was sighted often") {
  for (const bool often : {false, true}) {
    Life l;
    l.give({{5, 0, 2}, {5, 0.1, 2}}, often ? 12 : 2);
    l.decide();
    l.answer(mission::InspectOutcome::kFound);
    l.progress.inspected->found = {{FeatureId{1}, 0, {5, 0.05, 2}}};
    l.decide();
    REQUIRE(l.self.results().size() == 1);
    for (int i = 0; i < 15 && l.self.results().size() == 1; ++i) {
      l.time(10 + 6 * i);
      l.progress = {};
      l.decide();
      l.answer(mission::InspectOutcome::kRefusedView);
      l.decide();
    }
    REQUIRE(l.self.results().size() == (often ? 1 : 2));
    if (!often) CHECK_FALSE(l.self.results().rbegin()->second.inspection.found);
  }
}

TEST_CASE(
    "an area that was refused once and then is out of reach is given up: soon only "
    "where one was given up before") {
  Life l;
  mission::Status health;
  health.kind = mission::StatusKind::kHealth;
  health.regions = {{RegionId{0}, mission::RegionState::kExplored}};
  l.explorer.publish(store::RecordClass::kStatus, robot::kHealthKey, health);
  robot::pass(l.explorer, l.self, store::RecordClass::kStatus);
  const auto refused_once_then_out_of_reach = [&] {
    reveal(l.self, {-6, -6, 0.1}, {6, 6, 7}, wall);
    l.progress = {};
    l.give({{5, 0, 2}});
    REQUIRE(l.decide().kind == Kind::kInspect);
    l.answer(mission::InspectOutcome::kRefusedView);
    reveal(l.self, {-6, -6, 0.1}, {6, 6, 7},
           [](const Vec3& p) { return (p - Vec3(2, 0, 2)).norm() > 0.8; });
  };
  double t_s = 10;
  const auto closed_by = [&](double until_s, std::size_t results) {
    for (; t_s < until_s && l.self.results().size() < results; t_s += 10) {
      l.decide();
      l.progress = {};
      l.time(t_s);
    }
    return l.self.results().size() == results;
  };
  refused_once_then_out_of_reach();
  CHECK_FALSE(closed_by(600, 1));
  REQUIRE(closed_by(3600, 1));

  // In the same spot once more.
  refused_once_then_out_of_reach();
  CHECK(closed_by(t_s + 590, 2));
}

TEST_CASE("an area that was sighted often is asked about for long, not for ever") {
  Life l;
  l.give({{5, 0, 2}}, 12);
  int looks = 0;
  const auto look = [&] {
    l.time(10 + 20 * ++looks);
    l.progress = {};
    l.decide();
    l.answer(mission::InspectOutcome::kRefusedView);
    l.decide();
  };
  while (looks < 100) look();
  CHECK(l.self.results().empty());  // more of its region may become known
  mission::Status health;
  health.kind = mission::StatusKind::kHealth;
  health.regions = {{RegionId{0}, mission::RegionState::kExplored}};
  l.explorer.publish(store::RecordClass::kStatus, robot::kHealthKey, health);
  robot::pass(l.explorer, l.self, store::RecordClass::kStatus);
  look();
  REQUIRE(l.self.results().size() == 1);
  CHECK_FALSE(l.self.results().begin()->second.inspection.found);

  Life explored;
  robot::pass(l.explorer, explored.self, store::RecordClass::kStatus);
  explored.give({{5, 0, 2}}, 12);
  int asked = 0;
  for (; asked < 100 && explored.self.results().empty(); ++asked) {
    explored.time(10 + 20 * asked);
    explored.progress = {};
    explored.decide();
    explored.answer(mission::InspectOutcome::kRefusedView);
    explored.decide();
  }
  CHECK(asked > 30);
  CHECK(asked < 100);
}

TEST_CASE("an area is looked at from elsewhere than a look there that named only what is known") {
  Life l;
  l.give({{5, 0, 2}});
  const robot::Intent first = l.decide();
  mission::Inspection i;
  i.area = {RobotId{1}, 99};
  i.area_position = {5, 0.1, 2};
  i.pose.p = first.goal.p;
  i.found = true;
  i.findings = {{FeatureId{1}, 0, {5, 0.15, 2}}};
  Life other;
  other.self.publish(store::RecordClass::kInspection, robot::result_key(i.area), i);
  other.give({{5, 0, 2}});
  const robot::Intent look = other.decide();
  REQUIRE(look.kind == Kind::kInspect);
  CHECK((look.goal.p - first.goal.p).norm() > 0.3);
}

TEST_CASE("an area whose pose is not reached in time does not hold up the others") {
  Life l;
  l.give({{5, 0, 2}, {5, 3, 2}});
  const robot::Intent look = l.decide();
  l.progress.state = robot::Progress::State::kMoving;
  l.time(20);
  const robot::Intent other = l.decide();
  REQUIRE(other.kind == Kind::kInspect);
  CHECK_FALSE(other.area == look.area);
}

TEST_CASE("an inspector unheard for long goes back to where it started") {
  Life l;
  l.give({{5, 0, 2}});
  l.decide();
  l.answer(mission::InspectOutcome::kEmpty);
  l.decide();
  l.progress = {};
  l.time(kUnheard_s + 5);
  CHECK(l.decide().goal.p.isApprox(l.mission.robot(RobotId{2}).start.p));
}

TEST_CASE("released, an inspector goes home") {
  Life l;
  mission::Plan plan;
  plan.kind = mission::PlanKind::kAllocation;
  plan.allocations = {{RobotId{2}, RobotId{1}, kNoRegion, {}}};
  l.explorer.publish(store::RecordClass::kPlan, robot::plan_key(plan.kind), plan);
  robot::pass(l.explorer, l.self, store::RecordClass::kPlan);
  const robot::Intent home = l.decide();
  CHECK(home.activity == mission::Activity::kReturning);
  CHECK(home.goal.p.isApprox(l.mission.robot(RobotId{2}).start.p));
}
