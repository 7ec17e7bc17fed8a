#include <catch2/catch.hpp>

#include "common/dds/convert.h"
#include "common/dds/map_block.h"
#include "commsim/world/activity.h"
#include "commsim/world/bounds.h"
#include "commsim/world/coverage.h"
#include "commsim/world/ledger.h"
#include "tests/unit/map/said.h"
#include "tests/unit/world/fixtures.h"

using namespace muster;
using namespace muster::world;
using namespace muster::world::testing;

namespace {

const RobotId kInspector{3};

store::RecordHeader header(RobotId by, store::RecordClass cls, std::uint64_t seq) {
  store::RecordHeader h;
  h.author = {by, 1};
  h.cls = cls;
  h.key = seq;
  h.seq = seq;
  return h;
}

mission::Inspected found(const std::vector<std::uint32_t>& ids, const Bytes& image) {
  mission::Inspected answer;
  answer.outcome = mission::InspectOutcome::kFound;
  for (const std::uint32_t id : ids) answer.found.push_back({FeatureId{id}, 0, Vec3::Zero()});
  answer.payload = image;
  return answer;
}

/// The records an inspector writes for one result: part 0 with the ids, then the image in two
/// pieces.
std::vector<store::Record> records(RobotId by, const mission::Inspected& answer) {
  mission::Inspection body;
  body.area = {RobotId{2}, 5};
  body.done = SimTime::from_s(10);
  body.found = true;
  body.findings = answer.found;
  body.parts = 3;
  body.payload_bytes = static_cast<std::uint32_t>(answer.payload.size());
  std::vector<store::Record> result;
  result.push_back(dds::encode_record(header(by, store::RecordClass::kInspection, 1), body));
  const auto half = static_cast<std::ptrdiff_t>(answer.payload.size() / 2);
  for (std::uint32_t part = 1; part <= 2; ++part) {
    body.part = part;
    body.payload = part == 1 ? Bytes(answer.payload.begin(), answer.payload.begin() + half)
                             : Bytes(answer.payload.begin() + half, answer.payload.end());
    result.push_back(dds::encode_record(header(by, store::RecordClass::kImage, part), body));
  }
  return result;
}

std::vector<Feature> three_features() {
  return {feature(0, {0, 0, 2}, {1, 0, 0}), feature(1, {1, 0, 2}, {1, 0, 0}),
          feature(2, {2, 0, 2}, {1, 0, 0})};
}

const Bytes kImage{1, 2, 3, 4, 5};

}  // namespace

TEST_CASE(
    "a feature is delivered when its result and every part of its image arrived, in any order") {
  FeatureLedger ledger(three_features());
  const auto answer = found({0, 1}, kImage);
  CHECK(ledger.answered(kInspector, answer, SimTime::from_s(10)).size() == 2);
  const auto sent = records(kInspector, answer);
  CHECK(ledger.received(sent[2], SimTime::from_s(20)).delivered.empty());
  CHECK(ledger.received(sent[0], SimTime::from_s(21)).delivered.empty());
  CHECK(ledger.received(sent[0], SimTime::from_s(22)).delivered.empty());
  CHECK(ledger.received(sent[1], SimTime::from_s(23)).delivered.size() == 2);
  CHECK(ledger.received(sent[1], SimTime::from_s(24)).delivered.empty());
  CHECK(ledger.count_delivered() == 2);
  CHECK(ledger.delivered_time(2) == SimTime::from_s(23));
  CHECK_FALSE(ledger.delivered_time(3));
}

TEST_CASE("an id the world never gave this robot is refused") {
  FeatureLedger ledger(three_features());
  ledger.answered(kInspector, found({0}, kImage), {});
  CHECK_FALSE(ledger.received(records(kInspector, found({2}, kImage))[0], {}).violation.empty());
  CHECK_FALSE(ledger.received(records(RobotId{4}, found({0}, kImage))[0], {}).violation.empty());
  CHECK(ledger.count_delivered() == 0);
}

TEST_CASE("an image the world never gave is refused") {
  FeatureLedger ledger(three_features());
  ledger.answered(kInspector, found({0}, kImage), {});
  const auto sent = records(kInspector, found({0}, {5, 4, 3, 2, 1}));
  CHECK(ledger.received(sent[0], {}).violation.empty());
  CHECK(ledger.received(sent[1], {}).violation.empty());
  CHECK_FALSE(ledger.received(sent[2], {}).violation.empty());
  CHECK(ledger.count_delivered() == 0);
}

TEST_CASE("what a robot inspected and took with it is what has to be done again") {
  FeatureLedger ledger(three_features());
  const RobotId gone{3}, other{4};
  const auto told = found({0}, kImage), untold = found({1, 2}, kImage);
  ledger.answered(gone, told, SimTime::from_s(10));
  for (const auto& record : records(gone, told)) ledger.received(record, SimTime::from_s(11));
  ledger.answered(gone, untold, SimTime::from_s(20));
  CHECK(ledger.lost_with(other).empty());
  ledger.answered(other, found({2}, kImage), SimTime::from_s(40));
  ledger.answered(other, found({2}, kImage), SimTime::from_s(50));
  const auto lost = ledger.lost_with(gone);
  REQUIRE(lost.size() == 2);
  CHECK(lost[0].feature == FeatureId{1});
  CHECK(lost[0].inspected == SimTime::from_s(20));
  CHECK_FALSE(lost[0].again);
  CHECK(lost[1].feature == FeatureId{2});
  CHECK(lost[1].again == SimTime::from_s(40));
  CHECK(lost[1].again_by == other);
}

TEST_CASE("what somebody else had delivered from an earlier look need not be done again") {
  FeatureLedger ledger(three_features());
  const RobotId gone{3}, other{4};
  const auto first = found({0}, kImage);
  ledger.answered(other, first, SimTime::from_s(10));
  ledger.answered(gone, found({0}, kImage), SimTime::from_s(20));
  for (const auto& record : records(other, first)) ledger.received(record, SimTime::from_s(30));
  CHECK(ledger.lost_with(gone).empty());
}

TEST_CASE("with its disk goes what a robot inspected before and nobody was told") {
  FeatureLedger ledger(three_features());
  const RobotId robot{3};
  const auto told = found({0}, kImage), again = found({1}, {1, 1, 1});
  ledger.answered(robot, told, SimTime::from_s(10));
  for (const auto& record : records(robot, told)) ledger.received(record, SimTime::from_s(11));
  ledger.answered(robot, found({1, 2}, kImage), SimTime::from_s(20));
  ledger.answered(robot, again, SimTime::from_s(50));
  for (const auto& record : records(robot, again)) ledger.received(record, SimTime::from_s(60));
  ledger.answered(robot, found({0}, kImage), SimTime::from_s(70));
  const auto lost = ledger.lost_with(robot, SimTime::from_s(30));
  REQUIRE(lost.size() == 2);
  CHECK(lost[0].feature == FeatureId{1});
  CHECK(lost[0].again == SimTime::from_s(50));
  CHECK(lost[0].again_by == robot);
  CHECK(lost[1].feature == FeatureId{2});
  CHECK_FALSE(lost[1].again);
}

TEST_CASE("what the station's disk took with it is delivered when it is told again") {
  FeatureLedger ledger(three_features());
  const auto look = found({0}, kImage);
  ledger.answered(kInspector, look, SimTime::from_s(1));
  const auto sent = records(kInspector, look);
  for (const auto& record : sent) ledger.received(record, SimTime::from_s(2));
  REQUIRE(ledger.count_delivered() == 1);
  ledger.station_lost_all();
  CHECK(ledger.count_delivered() == 0);
  for (const auto& record : sent) ledger.received(record, SimTime::from_s(9));
  CHECK(ledger.count_delivered() == 1);
  CHECK(ledger.delivered_time(1) == SimTime::from_s(9));
}

TEST_CASE("areas are counted as true, false and duplicate") {
  FeatureLedger ledger(three_features());
  ledger.answered(kInspector, found({0}, kImage), {});
  ledger.answered(kInspector, found({0}, kImage), {});
  mission::Inspected empty;
  empty.outcome = mission::InspectOutcome::kEmpty;
  ledger.answered(kInspector, empty, {});
  CHECK(ledger.areas().real == 1);
  CHECK(ledger.areas().duplicate == 1);
  CHECK(ledger.areas().empty == 1);
}

TEST_CASE("features.csv has a row per feature, empty where something has not happened") {
  FeatureLedger ledger(three_features());
  ledger.sighted(FeatureId{1}, RobotId{2}, SimTime::from_s(4));
  CHECK_FALSE(ledger.sighted(FeatureId{1}, RobotId{2}, SimTime::from_s(5)));
  const std::string csv = ledger.csv(three_features());
  CHECK(csv.find("\n1,0,1.000,0.000,2.000,4.000,2,,,\n") != std::string::npos);
}

TEST_CASE("coverage counts a surface voxel when it or a neighbour is occupied in some block") {
  mission::Mission m = mission_of({robot(1, mission::Role::kStation, {0, 0, 2})});
  Coverage coverage(m, {{0.1, 0.1, 0.1}, {0.3, 0.1, 0.1}, {1.1, 0.1, 0.1}, {1.7, 0.1, 0.1}});
  CHECK(coverage.total() == 4);
  std::vector<map::Voxel> voxels(4096, map::Voxel::kUnknown);
  voxels[0] = map::Voxel::kOccupied;
  voxels[5] = map::Voxel::kFree;
  mission::MapBlock block = dds::map_block(std::array{map::said({0, 0, 0}, voxels)}, 0.2);
  coverage.received(dds::encode_record(header(RobotId{2}, store::RecordClass::kMap, 1), block));
  CHECK(coverage.share() == Approx(0.5));
  block.blocks = {1, 2, 3};
  CHECK_THROWS_AS(
      coverage.received(dds::encode_record(header(RobotId{2}, store::RecordClass::kMap, 2), block)),
      BadInput);
}

TEST_CASE("without surfaces coverage is the known share of the boxes") {
  mission::Mission m = mission_of({robot(1, mission::Role::kStation, {0, 0, 2})});
  m.boxes = {Box::from_corners({0, 0, 0}, {3.2, 3.2, 6.4})};
  Coverage coverage(m, {});
  const mission::MapBlock block =
      dds::map_block(std::array{map::said({0, 0, 0}, map::Voxel::kFree)}, 0.2);
  coverage.received(dds::encode_record(header(RobotId{2}, store::RecordClass::kMap, 1), block));
  CHECK(coverage.share() == Approx(0.5));
}

TEST_CASE("idle and waste come from what robots did") {
  mission::Mission m = mission_of({robot(1, mission::Role::kStation, {0, 0, 2}),
                                   robot(2, mission::Role::kExplorer, {2, 0, 2}),
                                   robot(3, mission::Role::kInspector, {4, 0, 2})});
  ActivityMeter meter(m);
  const auto go = [&](int ticks, double station_mps, double inspector_mps, bool inspecting) {
    for (int i = 0; i < ticks; ++i) {
      meter.tick({{true, false, station_mps}, {true, false, 1}, {true, inspecting, inspector_mps}});
    }
  };
  std::vector<Vec3> ends;
  for (int i = 0; i < 48 * 31; ++i)
    ends.emplace_back(7, -3 + 0.13 * (i % 48), 0.5 + 0.1 * (i / 48));
  meter.saw(1, {2, 0, 2}, ends, 48);
  go(10, 0, 1, false);                // the explorer sees new space, the inspector travels
  go(20, 1, 0, true);                 // … and inspects
  meter.saw(1, {2, 0, 2}, ends, 48);  // nothing new
  go(50, 0, 0, false);                // nobody does anything
  CHECK(meter.idle().gcs_s == Approx(6));
  CHECK(meter.idle().explorers_s == Approx(7));
  CHECK(meter.waste().explorers_s == Approx(7));
  CHECK(meter.idle().inspectors_s == Approx(6));
  CHECK(meter.waste().inspectors_s == Approx(5));
}

TEST_CASE("the lower bound is the farthest feature, or the work shared by all inspectors") {
  mission::Mission m = mission_of({robot(1, mission::Role::kInspector, {0, 0, 0}),
                                   robot(2, mission::Role::kInspector, {1, 0, 0})});
  CHECK(lower_bound_s(m, {}) == 0);
  CHECK(lower_bound_s(m, {feature(0, {16, 0, 0}, {1, 0, 0})}) == Approx(5 + 3));
  std::vector<Feature> many;
  for (std::uint32_t i = 0; i < 10; ++i) many.push_back(feature(i, {0, 2.0 * i, 0}, {1, 0, 0}));
  CHECK(lower_bound_s(m, many) == Approx((10 * 3 + 13.0 / 2 * 0) / 2.0).margin(4));
  m.inspect.shared = true;
  CHECK(lower_bound_s(m, many) < 12);
}
