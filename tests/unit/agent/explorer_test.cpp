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
  void hear_orders(bool surveyed = false) {
    mission::Plan plan;
    plan.kind = mission::PlanKind::kAssignment;
    plan.allocations = {{kSelf, kNoRobot, RegionId{0}, {}}};
    if (surveyed) plan.allocations.push_back({kNoRobot, kSelf, RegionId{0}, {}});
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
  CHECK(again.areas().begin()->second.area.unexplained == 2);
}

namespace {

/// Works on a region of which everything is known and nothing is to be seen.
struct Empty : Blank {
  Empty() {
    reveal(k, {-6, -6, 0.1}, {12, 6, 7}, [](const Vec3&) { return false; });
    at(t_s);
    hear_orders();
  }
  mission::RegionProgress after(double span_s) {
    for (const double end_s = t_s + span_s; t_s < end_s; t_s += 2) {
      mission::Scan scan;
      scan.sensor.p = k.position();
      explorer.on_scan(k, scan);
      at(t_s);
    }
    return k.health(kSelf)->body.regions.front();
  }
  double t_s = 100;
};

}  // namespace

TEST_CASE("a region is surveyed, and done after the round of thorough looks") {
  Empty e;
  CHECK(e.after(20).state == mission::RegionState::kSurveyed);
  e.hear_orders(true);
  CHECK(e.after(20).state == mission::RegionState::kDone);
}

TEST_CASE("a region is not done while something that was sighted may become an area yet") {
  Empty e;
  mission::Area area;
  area.position = {5, 0, 2};
  area.region = RegionId{0};
  e.k.publish(store::RecordClass::kArea, 7, area);
  mission::Inspection result;
  result.area = {kSelf, 7};
  result.area_position = area.position;
  result.found = true;
  result.findings = {{FeatureId{1}, 0, {5, 0, 2}}};
  e.k.publish(store::RecordClass::kInspection, robot::result_key(result.area), result);
  REQUIRE(e.after(20).state == mission::RegionState::kSurveyed);
  mission::Sightings look;
  look.sensor.p = {5, -3, 2};
  look.seen = {{{5, 0.6, 2}, 0, 0, 0}};  // beside what is known: a second one would tell
  e.explorer.on_sightings(e.k, look);
  CHECK(e.after(20).state == mission::RegionState::kExplored);
  CHECK(e.k.areas().size() == 1);
  CHECK(e.after(40).state == mission::RegionState::kExplored);
  CHECK(e.k.areas().size() == 2);  // to be inspected
}
