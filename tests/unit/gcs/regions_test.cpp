#include "gcs/strategy/regions.h"

#include <catch2/catch.hpp>

#include "tests/unit/robot/fixtures.h"

using namespace muster;
using gcs::Regions;

namespace {

constexpr RobotId kExplorer{1}, kInspector{2};
constexpr RegionId kRegion{0};

/// A station (0) with one explorer and one inspector.
struct Site {
  mission::Mission mission = robot::small_mission();
  robot::Knowledge station{mission, RobotId{0}, 1};
  Regions regions{mission};

  Site() { regions.assign_all(station); }
  /// Whom the newest assignment record gives what.
  RegionId assigned(RobotId robot) const {
    const auto* plan = station.plan(RobotId{0}, mission::PlanKind::kAssignment);
    for (const mission::Allocation& a : plan->body.allocations) {
      if (a.robot == robot) return a.region;
    }
    return kNoRegion;
  }
};

}  // namespace

TEST_CASE("an explorer that was given up and comes after all goes on with its region") {
  Site s;
  REQUIRE(s.assigned(kExplorer) == kRegion);
  s.regions.lost(s.station, kExplorer);
  CHECK(s.assigned(kExplorer) == kNoRegion);
  CHECK(s.regions.state(kRegion) == mission::RegionState::kPending);

  CHECK(s.regions.report(s.station, kExplorer));
  CHECK(s.assigned(kExplorer) == kRegion);
  CHECK(s.assigned(kInspector) == kRegion);
  CHECK(s.regions.state(kRegion) == mission::RegionState::kAssigned);
  CHECK_FALSE(s.regions.groups().at(kExplorer).lost);
  CHECK_FALSE(s.regions.groups().at(kExplorer).released);
}

TEST_CASE("an explorer whose inspectors went to others while it was given up gets some again") {
  mission::Mission mission = robot::small_mission();
  mission.boxes = {Box::from_corners({2, -4, 0.3}, {6, 4, 6}),
                   Box::from_corners({6, -4, 0.3}, {10, 4, 6})};
  const auto add = [&](mission::Role role, std::uint32_t id) {
    mission::RobotConfig r = mission.fleet[role == mission::Role::kExplorer ? 1 : 2];
    r.id = RobotId{id};
    mission.fleet.push_back(r);
  };
  add(mission::Role::kExplorer, 3);
  for (std::uint32_t id = 4; id <= 6; ++id) add(mission::Role::kInspector, id);
  robot::Knowledge station(mission, RobotId{0}, 1);
  Regions regions(mission);
  regions.assign_all(station);
  const auto crew = [&](std::uint32_t explorer) {
    return regions.groups().at(RobotId{explorer}).inspectors.size();
  };
  REQUIRE(crew(1) == 2);
  regions.lost(station, RobotId{1});
  regions.lost(station, RobotId{3});
  REQUIRE(regions.report(station, RobotId{3}));  // comes first and gets all
  REQUIRE(crew(3) == 4);
  REQUIRE(regions.report(station, RobotId{1}));
  CHECK(crew(1) == 2);
  CHECK(crew(3) == 2);
  CHECK(regions.groups().at(RobotId{1}).region != kNoRegion);
  CHECK_FALSE(regions.report(station, RobotId{3}));
}

TEST_CASE("a station that starts again takes up its assignment, and what is done stays done") {
  mission::Mission mission = robot::small_mission();
  mission.boxes = {Box::from_corners({2, -4, 0.3}, {6, 4, 6}),
                   Box::from_corners({6, -4, 0.3}, {10, 4, 6})};
  robot::Knowledge station(mission, RobotId{0}, 1);
  Regions before(mission);
  before.assign_all(station);
  robot::Knowledge explorer(mission, kExplorer, 1);
  mission::Status health;
  health.kind = mission::StatusKind::kHealth;
  health.regions = {{.region = RegionId{0}, .state = mission::RegionState::kDone}};
  explorer.publish(store::RecordClass::kStatus, robot::kHealthKey, health);
  robot::pass(explorer, station, store::RecordClass::kStatus);
  robot::hear(station, explorer);
  const bool done = GENERATE(false, true);
  if (done) {
    station.exchange().on_beacon(kExplorer, 1, 1, explorer.store().digest(), station.now());
    robot::pass(station, explorer, store::RecordClass::kPlan);
    station.exchange().on_beacon(kExplorer, 1, 2, explorer.store().digest(), station.now());
    REQUIRE(before.report(station, kExplorer));
    REQUIRE(before.groups().at(kExplorer).region == RegionId{1});
  }

  Regions after(mission);
  CHECK(after.resume(station));
  for (const RegionId region : {RegionId{0}, RegionId{1}}) {
    CHECK(after.state(region) == before.state(region));
  }
  CHECK(after.groups().at(kExplorer).region == before.groups().at(kExplorer).region);
  CHECK(after.groups().at(kExplorer).inspectors == std::vector{kInspector});
  CHECK_FALSE(after.groups().at(kExplorer).lost);
  CHECK_FALSE(after.groups().at(kExplorer).released);
}

TEST_CASE("a station that kept nothing leaves everybody with what they say they work on") {
  mission::Mission mission = robot::small_mission();
  mission.boxes = {Box::from_corners({2, -4, 0.3}, {6, 4, 6}),
                   Box::from_corners({6, -4, 0.3}, {10, 4, 6})};
  robot::Knowledge station(mission, RobotId{0}, 2), explorer(mission, kExplorer, 1);
  mission::Status health;
  health.kind = mission::StatusKind::kHealth;
  health.regions = {{.region = RegionId{1}, .state = mission::RegionState::kAssigned}};
  explorer.publish(store::RecordClass::kStatus, robot::kHealthKey, health);
  mission::Plan crew;
  crew.kind = mission::PlanKind::kAllocation;
  crew.allocations = {{kInspector, kExplorer, RegionId{1}, {}}};
  explorer.publish(store::RecordClass::kPlan, robot::plan_key(crew.kind), crew);
  robot::pass(explorer, station, store::RecordClass::kStatus);
  robot::pass(explorer, station, store::RecordClass::kPlan);
  Regions regions(mission);
  regions.assign_all(station);
  CHECK(regions.groups().at(kExplorer).region == RegionId{1});
  CHECK(regions.groups().at(kExplorer).inspectors == std::vector{kInspector});
  CHECK(regions.state(RegionId{0}) == mission::RegionState::kPending);
  CHECK(regions.state(RegionId{1}) == mission::RegionState::kAssigned);
}

TEST_CASE("a station without an assignment of its own has nothing to take up") {
  robot::Knowledge station(robot::small_mission(), RobotId{0}, 1);
  Regions regions(robot::small_mission());
  CHECK_FALSE(regions.resume(station));
}

TEST_CASE("what was surveyed is gone through again by who did, when nothing is pending") {
  mission::Mission mission = robot::small_mission();
  mission.boxes = {Box::from_corners({2, -4, 0.3}, {6, 4, 6}),
                   Box::from_corners({6, -4, 0.3}, {10, 4, 6}),
                   Box::from_corners({-4, -4, 0.3}, {2, 4, 6})};
  constexpr RobotId kOther{3};
  mission.fleet.push_back(mission.fleet[1]);
  mission.fleet.back().id = kOther;
  robot::Knowledge station(mission, RobotId{0}, 1);
  std::map<RobotId, robot::Knowledge> explorers;
  explorers.try_emplace(kExplorer, mission, kExplorer, 1);
  explorers.try_emplace(kOther, mission, kOther, 1);
  Regions regions(mission);
  regions.assign_all(station);
  const auto region = [&](RobotId id) { return regions.groups().at(id).region; };
  std::uint64_t beacon = 0;
  const auto report = [&](RobotId id, mission::RegionState state) {
    robot::Knowledge& k = explorers.at(id);
    mission::Status health;
    health.kind = mission::StatusKind::kHealth;
    health.regions = {{.region = region(id), .state = state}};
    k.publish(store::RecordClass::kStatus, robot::kHealthKey, health);
    robot::pass(k, station, store::RecordClass::kStatus);
    robot::hear(station, k);
    for (int i = 0; i < 2; ++i) {
      station.exchange().on_beacon(id, 1, ++beacon, k.store().digest(), station.now());
      for (const auto cls : {store::RecordClass::kPlan, store::RecordClass::kStatus})
        robot::pass(station, k, cls);
    }
    return regions.report(station, id);
  };
  const RegionId first = region(kExplorer), second = region(kOther);
  REQUIRE(first != second);

  REQUIRE(report(kExplorer, mission::RegionState::kSurveyed));
  const RegionId third = region(kExplorer);
  CHECK(regions.state(first) == mission::RegionState::kSurveyed);
  CHECK(regions.state(third) == mission::RegionState::kAssigned);
  REQUIRE(report(kExplorer, mission::RegionState::kSurveyed));
  const RegionId again = region(kExplorer);
  CHECK((again == first || again == third));
  CHECK(regions.state(again) == mission::RegionState::kAssigned);
  CHECK_FALSE(report(kExplorer, mission::RegionState::kSurveyed));  // as was known

  // When it is through with its own it helps the other.
  REQUIRE(report(kOther, mission::RegionState::kSurveyed));
  CHECK(region(kOther) == second);
  REQUIRE(report(kOther, mission::RegionState::kDone));
  CHECK(regions.state(second) == mission::RegionState::kDone);
  const RegionId last = again == first ? third : first;
  CHECK(region(kOther) == last);

  Regions later(mission);
  REQUIRE(later.resume(station));
  for (const RegionId r : {first, second, third}) CHECK(later.state(r) == regions.state(r));

  REQUIRE(report(kExplorer, mission::RegionState::kDone));
  CHECK(regions.groups().at(kExplorer).released);
  CHECK_FALSE(regions.all_done());
  REQUIRE(report(kOther, mission::RegionState::kDone));  // gets the inspector first
  REQUIRE(report(kOther, mission::RegionState::kDone));
  CHECK(regions.all_done());
}

TEST_CASE("what was surveyed by one who is lost stays surveyed") {
  Site s;
  robot::Knowledge explorer(s.mission, kExplorer, 1);
  mission::Plan plan = s.station.plan(RobotId{0}, mission::PlanKind::kAssignment)->body;
  plan.allocations.push_back({kNoRobot, kExplorer, kRegion, {}});
  s.station.publish(store::RecordClass::kPlan, robot::plan_key(plan.kind), plan);
  Regions regions(s.mission);
  REQUIRE(regions.resume(s.station));
  CHECK(regions.state(kRegion) == mission::RegionState::kAssigned);
  regions.lost(s.station, kExplorer);
  CHECK(regions.state(kRegion) == mission::RegionState::kSurveyed);
  CHECK(regions.report(s.station, kExplorer));
  CHECK(regions.groups().at(kExplorer).region == kRegion);
}

TEST_CASE("an area that is told of late is inspected by who was released") {
  Site s;
  robot::Knowledge explorer(s.mission, kExplorer, 1);
  std::uint64_t beacon = 0;
  const auto report = [&](mission::RegionState state) {
    mission::Status health;
    health.kind = mission::StatusKind::kHealth;
    health.regions = {{.region = kRegion, .state = state}};
    explorer.publish(store::RecordClass::kStatus, robot::kHealthKey, health);
    robot::pass(explorer, s.station, store::RecordClass::kStatus);
    robot::pass(explorer, s.station, store::RecordClass::kArea);
    robot::hear(s.station, explorer);
    for (int i = 0; i < 2; ++i) {
      s.station.exchange().on_beacon(kExplorer, 1, ++beacon, explorer.store().digest(),
                                     s.station.now());
      robot::pass(s.station, explorer, store::RecordClass::kPlan);
    }
    return s.regions.report(s.station, kExplorer);
  };
  REQUIRE(report(mission::RegionState::kSurveyed));
  REQUIRE(report(mission::RegionState::kDone));
  REQUIRE(s.regions.groups().at(kExplorer).released);
  CHECK_FALSE(report(mission::RegionState::kDone));
  mission::Area area;
  area.region = kRegion;
  explorer.publish(store::RecordClass::kArea, 7, area);
  CHECK(report(mission::RegionState::kDone));
  CHECK_FALSE(s.regions.all_done());
  CHECK(s.regions.groups().at(kExplorer).region == kRegion);
  CHECK_FALSE(report(mission::RegionState::kDone));  // without a result it is not
}
