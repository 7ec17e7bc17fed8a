#include "common/robot/knowledge.h"

#include <catch2/catch.hpp>

#include "tests/unit/robot/fixtures.h"

using namespace muster;

TEST_CASE("areas are counted by region, and a result is complete when all of its image is here") {
  constexpr RobotId kExplorer{1}, kInspector{2};
  constexpr RegionId kHere{0}, kElsewhere{1};
  const mission::Mission m = robot::small_mission();
  robot::Knowledge explorer(m, kExplorer, 1), inspector(m, kInspector, 1);
  mission::Area area;
  area.region = kHere;
  for (const std::uint64_t key : {1, 2}) explorer.publish(store::RecordClass::kArea, key, area);
  area.region = kElsewhere;
  explorer.publish(store::RecordClass::kArea, 3, area);
  const auto counts = [&](RegionId region) {
    const robot::AreaCount n = explorer.areas_in(region);
    return std::pair(n.found, n.inspected);
  };
  CHECK(counts(kHere) == std::pair(2u, 0u));
  CHECK(counts(kNoRegion) == std::pair(0u, 0u));

  const mission::AreaRef ref{kExplorer, 1};
  CHECK_FALSE(explorer.result_complete(ref));
  mission::Inspection result;
  result.area = ref;
  result.parts = 2;
  inspector.publish(store::RecordClass::kInspection, robot::result_key(ref), result);
  robot::pass(inspector, explorer, store::RecordClass::kInspection);
  CHECK(explorer.inspected(ref));
  CHECK_FALSE(explorer.result_complete(ref));
  CHECK(counts(kHere) == std::pair(2u, 1u));
  CHECK(counts(kElsewhere) == std::pair(1u, 0u));

  result.part = 1;
  inspector.publish(store::RecordClass::kImage, robot::image_key(ref, 1), result);
  robot::pass(inspector, explorer, store::RecordClass::kImage);
  CHECK(explorer.result_complete(ref));
}
