#include "common/robot/map_sharer.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>

#include "common/core/error.h"
#include "common/dds/map_block.h"
#include "common/map/block.h"
#include "tests/unit/robot/fixtures.h"

using namespace muster;
using namespace muster::robot;

namespace {

using store::RecordClass;

const mission::Mission kMission = small_mission();

/// An explorer and an inspector who are near each other for as long as they are told to be.
struct Two {
  Knowledge a{kMission, RobotId{1}, 1}, b{kMission, RobotId{2}, 1};
  MapSharer from_a, from_b;
  std::uint64_t tick = 0;

  void fly(double seconds, bool together, bool exchange) {
    for (const std::uint64_t end = tick + static_cast<std::uint64_t>(10 * seconds); tick < end;) {
      ++tick;
      a.begin(time_of_tick(tick));
      b.begin(time_of_tick(tick));
      if (together) hear(a, b), hear(b, a);
      from_a.step(a);
      from_b.step(b);
      if (!exchange) continue;
      pass(a, b, RecordClass::kMap);
      pass(b, a, RecordClass::kMap);
    }
  }
};

std::size_t records(const Knowledge& k) { return k.store().all(RecordClass::kMap).size(); }

/// One voxel, said by robot 1 in its `seq`th record.
store::Record word(std::uint64_t seq, map::Voxel state) {
  map::SaidBlock block{{0, 0, 0}, {}};
  map::put(state == map::Voxel::kFree ? block.said.free : block.said.occupied, 7, true);
  const store::RecordHeader header{{RobotId{1}, 1}, RecordClass::kMap, 100 + seq, seq, {}, {}};
  return dds::encode_record(header, dds::map_block(std::array{block}, 0.2));
}

}  // namespace

TEST_CASE("nothing is said of the map while nobody is there") {
  Two two;
  two.a.map().insert_free_ball({5, 0, 3}, 2);
  two.fly(20, false, false);
  CHECK(records(two.a) == 0);
  two.fly(0.1, true, false);
  CHECK(records(two.a) == 1);
}

TEST_CASE(
    "what one has said of the map the other does not say again, and what is told stays told") {
  Two two;
  two.a.map().insert_free_ball({5, 0, 3}, 2);
  two.fly(6, true, true);
  const std::size_t at_first = records(two.a);
  two.b.map().insert_free_ball({5, 0, 3}, 2);
  two.fly(60, true, true);
  CHECK(records(two.a) == at_first);
  CHECK(records(two.b) == at_first);
  CHECK(two.b.map().at(Vec3(5, 0, 3)) == map::Voxel::kFree);
}

TEST_CASE("in company much is said within five seconds, a little within half a minute") {
  Two two;
  two.fly(40, true, true);
  const std::size_t at_first = records(two.a);
  two.a.map().insert_free_ball({5, 0, 3}, 2);
  two.fly(5, true, true);
  CHECK(records(two.a) == at_first + 1);
  two.a.map().insert_free_ball({9, 0, 3}, 0.3);
  two.fly(10, true, true);
  CHECK(records(two.a) == at_first + 1);
  two.fly(25, true, true);
  CHECK(records(two.a) == at_first + 2);
  CHECK(two.b.map().at(Vec3(9, 0, 3)) == map::Voxel::kFree);
}

TEST_CASE("a large map is told in records that each fit a packet") {
  Two two;
  two.a.map().insert_free_ball({0, 0, 4}, 14);
  two.fly(10, true, true);
  CHECK(records(two.a) > 3);
  for (const store::Record* r : two.a.store().all(RecordClass::kMap))
    CHECK(r->bytes.size() < 16'000);
  CHECK(two.b.map().at(Vec3(10, 9, 4)) == map::Voxel::kFree);
}

TEST_CASE("of an author's words on a voxel the last one holds, in whatever order they arrive") {
  using map::Voxel;
  const std::vector<store::Record> words{word(1, Voxel::kFree), word(2, Voxel::kOccupied),
                                         word(3, Voxel::kFree), word(4, Voxel::kOccupied)};
  std::vector<std::size_t> order{0, 1, 2, 3};
  do {
    Knowledge k(kMission, RobotId{2}, 1);
    std::size_t newest = 0;
    for (const std::size_t i : order) {
      k.receive(RobotId{1}, i + 1, words[i]);
      newest = std::max(newest, i);
      const Voxel should = newest % 2 == 0 ? Voxel::kFree : Voxel::kOccupied;
      CHECK(k.map().at(map::VoxelKey{7, 0, 0}) == should);
    }
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_CASE("map records of another resolution or in an unknown code are refused with a reason") {
  const auto refusal = [](mission::MapBlock block) -> std::string {
    try {
      dds::said_blocks(block, 0.2);
    } catch (const BadInput& bad) {
      return bad.what();
    }
    return "";
  };
  mission::MapBlock block = dds::map_block({}, 0.2);
  CHECK(refusal(block).empty());
  block.encoding = mission::BlockEncoding{1};
  CHECK(refusal(block) == "map block: encoding 1 is not known here, only 2 (arithmetic)");
  block = dds::map_block({}, 0.1);
  CHECK(refusal(block) == "map block: resolution_m is not the mission's");
}
