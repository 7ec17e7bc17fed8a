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
