#include "agent/strategy/area_fitter.h"

#include <catch2/catch.hpp>

#include "tests/unit/robot/fixtures.h"

using namespace muster;
using agent::AreaFitter;
using robot::Knowledge;

namespace {

constexpr RegionId kRegion{0};

mission::Sightings look(const Vec3& from, std::initializer_list<Vec3> at) {
  mission::Sightings s;
  s.sensor.p = from;
  for (const Vec3& p : at) s.seen.push_back({p, 0, 0, 0});
  return s;
}

/// The newest area is inspected from `from`; `found`: where the answer's features are.
void inspect(Knowledge& k, const mission::AreaRef& ref, const Vec3& from,
             std::initializer_list<Vec3> found) {
  mission::Inspection i;
  i.area = ref;
  i.area_position = k.areas().at(ref).area.position;
  i.pose.p = from;
  i.found = found.size() > 0;
  std::uint32_t id = 0;
  for (const Vec3& p : found) i.findings.push_back({FeatureId{id++}, 0, p});
  k.publish(store::RecordClass::kInspection, robot::result_key(ref), i);
}

}  // namespace

TEST_CASE("sightings near each other from one side are one area, from two sides two") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}, {5.2, 0, 2}}), kRegion);
  fitter.take(k, look({6, -3, 2}, {{5.1, 0.1, 2}}), kRegion);
  REQUIRE(k.areas().size() == 1);
  CHECK(k.areas().begin()->second.area.normal.y() < -0.9);
  fitter.take(k, look({5, 3, 2}, {{5.1, 0.1, 2}}), kRegion);
  CHECK(k.areas().size() == 2);
}

TEST_CASE("a sighting that no finding explains begins an area of its own, a few times at most") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}, {5.45, 0, 2}}), kRegion);
  REQUIRE(k.areas().size() == 1);
  const mission::AreaRef first = k.areas().begin()->first;
  inspect(k, first, {5, -2, 2}, {{5, 0, 2}});
  fitter.review(k);
  REQUIRE(k.areas().size() == 2);
  const mission::AreaRef second = k.areas().rbegin()->first;
  CHECK((k.areas().at(second).area.position - Vec3(5.45, 0, 2)).norm() < 0.01);
  // The answer names the first again: asked once more, then never.
  for (int i = 0; i < 6; ++i) {
    inspect(k, k.areas().rbegin()->first, {5, -2, 2}, {{5, 0, 2}});
    fitter.review(k);
    fitter.take(k, look({5, -3, 2}, {{5.45, 0, 2}}), kRegion);
  }
  CHECK(k.areas().size() <= 4);
}

TEST_CASE("what was inspected and explained is not fitted again") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}, {8, 0, 2}}), kRegion);
  REQUIRE(k.areas().size() == 2);
  for (const auto& [ref, known] : std::map(k.areas())) {
    if (known.area.position.x() < 6)
      inspect(k, ref, {5, -2, 2}, {{5.05, 0, 2}});
    else
      inspect(k, ref, {8, -2, 2}, {});  // a false area
  }
  fitter.review(k);
  fitter.take(k, look({5, -3, 2}, {{5.1, 0, 2}, {8.2, 0, 2}}), kRegion);
  CHECK(k.areas().size() == 2);
}
