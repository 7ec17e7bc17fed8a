#include "agent/strategy/subgroup.h"

#include <catch2/catch.hpp>

#include "agent/strategy/slei3d_inspector.h"
#include "tests/unit/agent/place.h"

using namespace muster;
using namespace muster::agent;

namespace {

/// An explorer with two inspectors, 2 and 3.
struct Group {
  mission::Mission mission = two_inspectors();
  robot::Knowledge station{mission, RobotId{0}, 1}, explorer{mission, RobotId{1}, 1},
      first{mission, RobotId{2}, 1}, second{mission, RobotId{3}, 1};
  Subgroup subgroup;
  std::vector<mission::PlanningTime> planning;

  static mission::Mission two_inspectors() {
    mission::Mission m = robot::small_mission();
    mission::RobotConfig r = m.fleet.back();
    r.id = RobotId{3};
    r.start.p.y() = 2;
    m.fleet.push_back(r);
    return m;
  }

  Group() {
    mission::Plan plan;
    plan.kind = mission::PlanKind::kAssignment;
    plan.allocations = {{RobotId{1}, kNoRobot, RegionId{0}, {}},
                        {RobotId{2}, RobotId{1}, RegionId{0}, {}},
                        {RobotId{3}, RobotId{1}, RegionId{0}, {}}};
    station.publish(store::RecordClass::kPlan, robot::plan_key(plan.kind), plan);
    robot::pass(station, explorer, store::RecordClass::kPlan);
    time(1);
  }
  void time(double s) {
    be_at(station, s, {-5, 0, 0.5});
    be_at(explorer, s, {4, 0, 2});
    be_at(first, s, {5, 0, 2});
    be_at(second, s, {5, 2, 2});
  }
  void find(const Vec3& p) {
    explorer.publish(store::RecordClass::kArea, explorer.store().new_key(store::RecordClass::kArea),
                     area_at(p, p - Vec3::UnitX()));
  }
  void think(bool exploring = true) {
    subgroup.update(explorer, RegionId{0});
    subgroup.allocate(explorer, RegionId{0}, exploring, planning);
  }
  std::size_t given_to(RobotId id) {
    const auto* plan = explorer.plan(RobotId{1}, mission::PlanKind::kAllocation);
    return plan ? std::count_if(
                      plan->body.allocations.begin(), plan->body.allocations.end(),
                      [&](const auto& a) { return a.robot == id && a.area.author != kNoRobot; })
                : 0;
  }
};

}  // namespace

TEST_CASE("areas are given to whoever is in contact, and to nobody else") {
  Group g;
  for (int i = 0; i < 6; ++i) g.find({6, -3.0 + i, 2});
  g.think();
  CHECK(g.given_to(RobotId{2}) + g.given_to(RobotId{3}) == 0);
  robot::hear(g.explorer, g.first);
  g.think();
  CHECK(g.given_to(RobotId{2}) > 0);
  CHECK(g.given_to(RobotId{3}) == 0);
}

TEST_CASE("two inspectors in contact share the areas") {
  Group g;
  for (int i = 0; i < 8; ++i) g.find({6, -3.0 + i, 2});
  robot::hear(g.explorer, g.first);
  robot::hear(g.explorer, g.second);
  g.think();
  CHECK(g.given_to(RobotId{2}) + g.given_to(RobotId{3}) == 8);
  CHECK(g.given_to(RobotId{2}) > 1);
  CHECK(g.given_to(RobotId{3}) > 1);
}

TEST_CASE("what was given but never heard is open again once contact is gone") {
  Group g;
  for (int i = 0; i < 3; ++i) g.find({6, 1.0 * i, 2});
  robot::hear(g.explorer, g.first);
  g.think();
  CHECK(g.subgroup.open_areas() == 0);
  g.time(20);
  g.think();
  CHECK(g.subgroup.open_areas() == 3);
}

TEST_CASE("exploring is interrupted only for work that outweighs the way") {
  Group g;
  robot::hear(g.explorer, g.first);
  robot::hear(g.explorer, g.second);
  g.think();
  g.time(10);
  be_at(g.explorer, 10, {10, 4, 5});
  g.find({6, 0, 2});
  g.think();
  CHECK_FALSE(g.subgroup.next_visit(g.explorer, true));
  for (int i = 0; i < 14; ++i) g.find({6, -3.0 + 0.4 * i, 3});
  g.think();
  CHECK(g.subgroup.next_visit(g.explorer, true));
}

TEST_CASE("after exploring whoever has not heard the newest is visited") {
  Group g;
  g.find({6, 0, 2});
  g.think(false);
  CHECK(g.subgroup.next_visit(g.explorer, false));
}

TEST_CASE("missed twice an inspector is lost, its areas are open again; heard again it is back") {
  Group g;
  g.find({6, 0, 2});
  g.find({6, 1, 2});
  robot::hear(g.explorer, g.first);
  g.think();
  g.subgroup.missed(g.explorer, RobotId{2}, true);
  CHECK_FALSE(g.subgroup.mates().at(RobotId{2}).lost);
  g.subgroup.missed(g.explorer, RobotId{2}, true);
  CHECK(g.subgroup.mates().at(RobotId{2}).lost);
  CHECK(g.explorer.declared_lost().contains(RobotId{2}));
  g.time(40);
  g.think();
  CHECK(g.subgroup.open_areas() == 2);
  robot::hear(g.explorer, g.first);
  g.think();
  CHECK_FALSE(g.subgroup.mates().at(RobotId{2}).lost);
}

TEST_CASE(
    "inspectors that are lost are searched for when work is left and nobody else to give it to") {
  Group g;
  g.find({6, 0, 2});
  const auto lose = [&](RobotId id) {
    for (int i = 0; i < 2; ++i) g.subgroup.missed(g.explorer, id, true);
  };
  g.think(false);
  lose(RobotId{2});
  g.time(100);
  g.think(false);
  REQUIRE(g.subgroup.next_visit(g.explorer, false));
  CHECK(g.subgroup.next_visit(g.explorer, false)->mate == RobotId{3});
  lose(RobotId{3});
  g.think(false);

  std::set<RobotId> visited;
  std::vector<Vec3> places;
  for (int i = 0; i < 6; ++i) {
    g.time(1000 * (i + 1));
    g.think(false);
    CHECK_FALSE(g.subgroup.next_visit(g.explorer, true));
    const auto visit = g.subgroup.next_visit(g.explorer, false);
    REQUIRE(visit);
    visited.insert(visit->mate);
    if (visit->mate == RobotId{2}) places.push_back(visit->place);
    g.subgroup.missed(g.explorer, visit->mate, true);
  }
  CHECK(visited == std::set{RobotId{2}, RobotId{3}});
  const auto tried = [&](const Vec3& p) {
    return std::ranges::any_of(places, [&](const Vec3& q) { return q.isApprox(p); });
  };
  CHECK(tried(gathering_place(g.mission, RegionId{0}, RobotId{2})));
  CHECK(tried(g.mission.robot(RobotId{2}).start.p));
}

TEST_CASE("an inspector is expected where its route ends, and in the end where it started") {
  Group g;
  mission::Plan route;
  route.kind = mission::PlanKind::kRoute;
  route.steps = {
      {{SimTime::from_s(30), {{7, 3, 2}, 0}}, mission::PlanAction::kInspect, kNoRobot, {}, 3},
      {{SimTime::from_s(60), {{8, 1, 2}, 0}}, mission::PlanAction::kWait, kNoRobot, {}, 0}};
  g.first.publish(store::RecordClass::kPlan, robot::plan_key(route.kind), route);
  robot::pass(g.first, g.explorer, store::RecordClass::kPlan);
  robot::hear(g.explorer, g.first);
  g.think();
  g.time(10);
  g.think();
  const auto expected = [&](double s) {
    return g.subgroup.expected_place(g.explorer, RobotId{2}, SimTime::from_s(s));
  };
  CHECK(expected(20).isApprox(Vec3(7, 3, 2)));
  CHECK(expected(50).isApprox(Vec3(8, 1, 2)));
  CHECK(expected(200).isApprox(Vec3(8, 1, 2)));
  CHECK(expected(kUnheard_s + 100).isApprox(g.mission.robot(RobotId{2}).start.p));
}
