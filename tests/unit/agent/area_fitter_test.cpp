#include "agent/strategy/area_fitter.h"

#include <catch2/catch.hpp>

#include "tests/unit/agent/place.h"

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

/// As `AreaFitter::take`, by who keeps its looks.
void take(Knowledge& k, AreaFitter& fitter, const mission::Sightings& sightings) {
  k.keep_look(kRegion, sightings);
  fitter.take(k, sightings, kRegion);
}

AreaFitter started_again(Knowledge& k) {
  AreaFitter fitter;
  fitter.recall(k);
  return fitter;
}

}  // namespace

TEST_CASE("sightings near each other from one side are one area, from two sides two") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}}), kRegion);
  fitter.take(k, look({5, -3, 2}, {{5.2, 0, 2}}), kRegion);
  fitter.take(k, look({6, -3, 2}, {{5.1, 0.1, 2}}), kRegion);
  REQUIRE(k.areas().size() == 1);
  CHECK(k.areas().begin()->second.area.normal.y() < -0.9);
  for (int i = 0; i < 2; ++i) fitter.take(k, look({5, 3, 2}, {{5.1, 0.1, 2}}), kRegion);
  CHECK(k.areas().size() == 2);
}

TEST_CASE("what no finding explains is asked for when seen again, a few times at most") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}}), kRegion);
  fitter.take(k, look({5, -3, 2}, {{5.45, 0, 2}}), kRegion);
  REQUIRE(k.areas().size() == 1);
  const mission::AreaRef first = k.areas().begin()->first;
  inspect(k, first, {5, -2, 2}, {{5, 0, 2}});
  fitter.review(k, false);
  CHECK(k.areas().size() == 1);  // one sighting may be a stray one
  fitter.take(k, look({5, -3, 2}, {{5.5, 0, 2}}), kRegion);
  k.begin(SimTime::from_s(20));
  fitter.review(k, false);
  REQUIRE(k.areas().size() == 2);
  const mission::AreaRef second = k.areas().rbegin()->first;
  CHECK((k.areas().at(second).area.position - Vec3(5.475, 0, 2)).norm() < 0.01);
  // The answer names the first again: asked once more, then never.
  for (int i = 0; i < 6; ++i) {
    inspect(k, k.areas().rbegin()->first, {5, -2, 2}, {{5, 0, 2}});
    fitter.review(k, false);
    fitter.take(k, look({5, -3, 2}, {{5.45, 0, 2}}), kRegion);
    fitter.take(k, look({5, -3, 2}, {{5.45, 0, 2}}), kRegion);
  }
  CHECK(k.areas().size() <= 4);
}

TEST_CASE("what was seen but once beside something known is asked for after a while") {
  const mission::Mission m = robot::small_mission();
  for (const bool explored : {false, true}) {
    Knowledge k(m, RobotId{1}, 1);
    AreaFitter fitter;
    fitter.take(k, look({5, -3, 2}, {{5, 0, 2}}), kRegion);
    inspect(k, k.areas().begin()->first, {5, -2, 2}, {{5, 0, 2}});
    fitter.review(k, false);
    fitter.take(k, look({5, -3, 2}, {{5.7, 0, 2}}), kRegion);
    k.begin(SimTime::from_s(20));
    fitter.review(k, false);
    CHECK(k.areas().size() == 1);
    if (!explored) k.begin(SimTime::from_s(60));
    fitter.review(k, explored);
    CHECK(k.areas().size() == 2);
  }
}

TEST_CASE("what lies in another box is left to who explores that one, but not forgotten") {
  mission::Mission m = robot::small_mission();
  m.boxes.push_back(Box::from_corners({10, -4, 0.3}, {14, 4, 6}));
  const Vec3 beyond(11.2, 0, 2), from(9, -3, 2);
  for (const bool found_by_others : {false, true}) {
    Knowledge k(m, RobotId{1}, 1);
    AreaFitter fitter;
    for (int i = 0; i < 3; ++i) fitter.take(k, look(from, {beyond}), kRegion);
    k.begin(SimTime::from_s(100));
    fitter.review(k, false);
    CHECK(k.areas().empty());
    if (found_by_others) {
      Knowledge mate(m, RobotId{2}, 1);
      mate.publish(store::RecordClass::kArea, 7, agent::area_at(beyond, from));
      robot::pass(mate, k, store::RecordClass::kArea);
    }
    fitter.review(k, true);
    CHECK(k.areas().size() == 1);
    CHECK(k.areas().begin()->first.author == RobotId{found_by_others ? 2u : 1u});
  }
}

TEST_CASE("an explorer that is started again makes no second area of what it had found") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter before;
  before.take(k, look({5, -3, 2}, {{5, 0, 2}}), kRegion);
  REQUIRE(k.areas().size() == 1);
  AreaFitter after;
  after.take(k, look({5, -3, 2}, {{5.1, 0, 2}, {7, 0, 2}}), kRegion);
  CHECK(k.areas().size() == 2);
  // Once it is inspected, what was found says which sightings are of it, and a second one there is
  // news.
  inspect(k, k.areas().begin()->first, {5, -2, 2}, {{5, 0, 2}});
  AreaFitter later;
  for (int i = 0; i < 2; ++i) later.take(k, look({5, -3, 2}, {{5.05, 0, 2}, {5.4, 0, 2}}), kRegion);
  later.review(k, true);
  CHECK(k.areas().size() == 3);
}

TEST_CASE("an explorer that is started again with its looks goes on with its areas and doubts") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter before;
  for (int i = 0; i < 2; ++i) take(k, before, look({5, -3, 2}, {{5, 0, 2}}));
  take(k, before, look({5, -3, 2}, {{5.6, 0, 2}}));  // in doubt
  REQUIRE(k.areas().size() == 1);
  const auto first = [&]() -> const mission::Area& { return k.areas().begin()->second.area; };
  const std::uint64_t told = k.store().version();

  k.begin(SimTime::from_s(10));
  AreaFitter after = started_again(k);
  after.review(k, false);
  CHECK(k.store().version() == told);
  for (int i = 0; i < 2; ++i) take(k, after, look({5, -3, 2}, {{5.04, 0, 2}}));
  REQUIRE(k.areas().size() == 1);
  CHECK(first().unexplained == 4);
  CHECK((first().position - Vec3(5.02, 0, 2)).norm() < 0.01);
  k.begin(SimTime::from_s(60));
  after.review(k, false);
  REQUIRE(k.areas().size() == 2);
  CHECK((k.areas().rbegin()->second.area.position - Vec3(5.6, 0, 2)).norm() < 0.01);
}

TEST_CASE("a result that comes after a restart is held against what was sighted before it") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter before;
  for (int i = 0; i < 3; ++i) take(k, before, look({5, -3, 2}, {{5, 0, 2}, {5.17, 0, 2}}));
  REQUIRE(k.areas().size() == 2);
  AreaFitter after = started_again(k);
  for (const auto& [ref, known] : std::map(k.areas())) inspect(k, ref, {5, -2, 2}, {{5, 0, 2}});
  after.review(k, false);
  REQUIRE(k.areas().size() == 3);
  CHECK((k.areas().rbegin()->second.area.position - Vec3(5.17, 0, 2)).norm() < 0.01);
}

TEST_CASE("however often an explorer starts again, what no finding explains is asked a few times") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  for (int i = 0; i < 2; ++i) take(k, fitter, look({5, -3, 2}, {{5, 0, 2}, {5.5, 0, 2}}));
  for (int i = 0; i < 8; ++i) {
    for (const auto& [ref, known] : std::map(k.areas())) {
      if (!k.inspected(ref)) inspect(k, ref, {5, -2, 2}, {{5, 0, 2}});
    }
    fitter = started_again(k);
    k.begin(SimTime::from_s(100.0 * (i + 1)));
    fitter.review(k, true);
  }
  CHECK(k.areas().size() == 4);
}

TEST_CASE("two sightings near each other in one look are two features") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}, {5.3, 0, 2}}), kRegion);
  REQUIRE(k.areas().size() == 2);
  inspect(k, k.areas().begin()->first, {5, -2, 2}, {{5, 0, 2}});
  inspect(k, k.areas().rbegin()->first, {5, -2, 2}, {{5, 0, 2}});
  fitter.review(k, false);
  // One feature is known and two are seen again and again: one of them is not.
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}, {5.3, 0, 2}}), kRegion);
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}, {5.3, 0, 2}}), kRegion);
  CHECK(k.areas().size() == 3);
}

TEST_CASE("two areas of one look are not both explained by one finding") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  for (int i = 0; i < 3; ++i) fitter.take(k, look({5, -3, 2}, {{5, 0, 2}, {5.17, 0, 2}}), kRegion);
  REQUIRE(k.areas().size() == 2);
  for (const auto& [ref, known] : std::map(k.areas())) inspect(k, ref, {5, -2, 2}, {{5, 0, 2}});
  fitter.review(k, false);
  REQUIRE(k.areas().size() == 3);
  CHECK((k.areas().rbegin()->second.area.position - Vec3(5.17, 0, 2)).norm() < 0.01);
}

TEST_CASE("an answer about a feature off the middle of the sightings leaves them unexplained") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  for (int i = 0; i < 5; ++i) fitter.take(k, look({5, -3, 2}, {{5, 0, 2}}), kRegion);
  inspect(k, k.areas().begin()->first, {5, -2, 2}, {{5.35, 0, 2}});
  fitter.review(k, false);
  REQUIRE(k.areas().size() == 2);
  CHECK((k.areas().rbegin()->second.area.position - Vec3(5, 0, 2)).norm() < 0.01);
}

TEST_CASE("a finding explains what was sighted at a grazing angle from the far end of its wall") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  agent::reveal(k, {1, -5, 0.5}, {9, 5, 5}, [](const Vec3& p) { return p.y() > 0 && p.y() < 0.4; });
  AreaFitter fitter;
  fitter.take(k, look({2, -0.8, 2}, {{5, 0, 2}}), kRegion);
  fitter.take(k, look({8, -0.8, 2}, {{5, 0, 2}}), kRegion);
  REQUIRE(k.areas().size() == 1);
  inspect(k, k.areas().begin()->first, {3.5, -1, 2}, {{5, 0, 2}});
  fitter.review(k, false);
  for (int i = 0; i < 3; ++i) fitter.take(k, look({8, -0.8, 2}, {{5.05, 0, 2}}), kRegion);
  fitter.review(k, true);
  CHECK(k.areas().size() == 1);
}

TEST_CASE("a finding on one side of a thin wall explains nothing on the other") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  agent::reveal(k, {1, -5, 0.5}, {9, 5, 5}, [](const Vec3& p) { return p.y() > 0 && p.y() < 0.2; });
  AreaFitter fitter;
  fitter.take(k, look({4, -3, 2.5}, {{5, 0, 2}}), kRegion);
  inspect(k, k.areas().begin()->first, {4, -2, 2.2}, {{5, 0, 2}});
  fitter.review(k, false);
  for (int i = 0; i < 2; ++i) fitter.take(k, look({6, 3, 1.6}, {{5.1, 0.2, 2.0}}), kRegion);
  REQUIRE(k.areas().size() == 2);
  CHECK(k.areas().rbegin()->second.area.normal.y() > 0.5);
}

TEST_CASE("a sighting off a finding from where it hardly shows is of another surface") {
  const mission::Mission m = robot::small_mission();
  // Where the wall ends, the other face is seen at a right angle to that of the finding.
  const Vec3 end(5.3, 0.1, 2);
  for (const bool off : {false, true}) {
    Knowledge k(m, RobotId{1}, 1);
    agent::reveal(k, {1, -5, 0.5}, {9, 5, 5},
                  [&](const Vec3& p) { return p.y() > 0 && p.y() < 0.2 && p.x() < end.x(); });
    AreaFitter fitter;
    fitter.take(k, look({5, -3, 2}, {{5, 0, 2}}), kRegion);
    inspect(k, k.areas().begin()->first, {5, -2, 2}, {{5, 0, 2}});
    fitter.review(k, false);
    fitter.take(k, look({8, 0.3, 2}, {off ? end : Vec3(5.1, 0.05, 2)}), kRegion);
    k.begin(SimTime::from_s(100));
    fitter.review(k, true);
    CHECK(k.areas().size() == (off ? 2 : 1));
  }
}

TEST_CASE("an area says how many of its sightings the finding of another does not explain") {
  const mission::Mission m = robot::small_mission();
  for (const bool all : {false, true}) {
    Knowledge k(m, RobotId{1}, 1);
    AreaFitter fitter;
    fitter.take(k, look({5, -3, 2}, {{5, 0, 2}, {5.45, 0, 2}}), kRegion);
    fitter.take(k, look({5, -3, 2}, {{all ? 5.45 : 5.72, 0, 2}}), kRegion);
    REQUIRE(k.areas().size() == 2);
    const mission::AreaRef ref = k.areas().rbegin()->first;
    const auto second = [&]() -> const mission::Area& { return k.areas().at(ref).area; };
    CHECK(second().unexplained == 2);
    inspect(k, k.areas().begin()->first, {5, -2, 2}, {{5.3, 0, 2}});
    fitter.review(k, false);
    CHECK(second().unexplained == (all ? 0 : 1));
  }
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
  fitter.review(k, false);
  fitter.take(k, look({5, -3, 2}, {{5.1, 0, 2}, {8.2, 0, 2}}), kRegion);
  CHECK(k.areas().size() == 2);
}

TEST_CASE(
    "a sighting within four sigma of a finding is of it, several there or one beyond are not") {
  const mission::Mission m = robot::small_mission();
  for (const bool beyond : {false, true}) {
    Knowledge k(m, RobotId{1}, 1);
    AreaFitter fitter;
    fitter.take(k, look({5, -3, 2}, {{5, 0, 2}}), kRegion);
    inspect(k, k.areas().begin()->first, {5, -2, 2}, {{5, 0, 2}});
    fitter.take(k, look({5, -3, 2}, {{beyond ? 5.42 : 5.38, 0, 2}}), kRegion);
    k.begin(SimTime::from_s(100));
    fitter.review(k, true);
    CHECK(k.areas().size() == (beyond ? 2 : 1));
    if (beyond) continue;
    for (int i = 0; i < 5; ++i) fitter.take(k, look({5, -3, 2}, {{5.38, 0.01 * i, 2}}), kRegion);
    k.begin(SimTime::from_s(120));
    fitter.review(k, true);
    REQUIRE(k.areas().size() == 2);
    CHECK((k.areas().rbegin()->second.area.position - Vec3(5.38, 0.02, 2)).norm() < 0.02);
  }
}

TEST_CASE("two sightings of one look near one known feature are two, though both are near it") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}}), kRegion);
  inspect(k, k.areas().begin()->first, {5, -2, 2}, {{5, 0, 2}});
  for (int i = 0; i < 2; ++i)
    fitter.take(k, look({5, -3, 2}, {{5.02, 0, 2}, {5.2, 0, 2}}), kRegion);
  REQUIRE(k.areas().size() == 2);
  CHECK((k.areas().rbegin()->second.area.position - Vec3(5.2, 0, 2)).norm() < 0.01);
  // Nothing but the known one is there: the second was a false area.
  inspect(k, k.areas().rbegin()->first, {5, -2, 2}, {});
  fitter.review(k, false);
  for (int i = 0; i < 3; ++i)
    fitter.take(k, look({5, -3, 2}, {{5.02, 0, 2}, {5.2, 0, 2}}), kRegion);
  k.begin(SimTime::from_s(100));
  fitter.review(k, true);
  CHECK(k.areas().size() == 2);
}

TEST_CASE("sightings of one area that are of two features are shared out") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  // Never both in one look, and each within reach of the middle of both.
  for (int i = 0; i < 20; ++i)
    fitter.take(k, look({5, -3, 2}, {{i % 2 == 0 ? 5.0 : 5.36, 0, 2}}), kRegion);
  CHECK(k.areas().size() == 1);
  k.begin(SimTime::from_s(20));
  fitter.review(k, false);
  REQUIRE(k.areas().size() == 2);
  const Vec3 a = k.areas().begin()->second.area.position,
             b = k.areas().rbegin()->second.area.position;
  CHECK(std::abs((a - b).norm() - 0.36) < 0.01);
}

TEST_CASE("an area given up without an answer explains nothing") {
  const mission::Mission m = robot::small_mission();
  Knowledge k(m, RobotId{1}, 1);
  AreaFitter fitter;
  fitter.take(k, look({5, -3, 2}, {{5, 0, 2}}), kRegion);
  mission::Inspection i;
  i.area = k.areas().begin()->first;
  i.area_position = {5, 0, 2};
  i.parts = 0;
  k.publish(store::RecordClass::kInspection, robot::result_key(i.area), i);
  fitter.review(k, false);
  fitter.take(k, look({5, -3, 2}, {{5.05, 0, 2}}), kRegion);
  CHECK(k.areas().size() == 2);
}
