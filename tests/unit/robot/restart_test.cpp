#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "common/dds/map_block.h"
#include "common/map/block_codec.h"
#include "common/robot/robot.h"
#include "tests/unit/map/said.h"
#include "tests/unit/robot/fixtures.h"

using namespace muster;
using namespace muster::robot;
namespace fs = std::filesystem;

namespace {

struct Folder {
  ~Folder() { fs::remove_all(dir); }
  fs::path dir = fs::temp_directory_path() / fmt::format("muster_restart_{}", getpid());
};

std::string journal_file(const Folder& folder, RobotId robot) {
  return store::Journal::path(folder.dir, robot);
}

store::Journal journal(const Folder& folder, RobotId robot) {
  return {journal_file(folder, robot), robot, store::Journal::Durability::kProcess};
}

mission::Area area_at(const Vec3& p) {
  mission::Area area;
  area.position = p;
  return area;
}

/// Explores the first region all the time.
struct Looking : Idle {
  void on_sightings(Knowledge& k, const mission::Sightings& s) override {
    k.keep_look(RegionId{0}, s);
  }
};

mission::Sightings look(double x_m, std::vector<mission::Sighting> seen) {
  mission::Sightings look;
  look.sensor = {{x_m, 0, 1}, 0.5};
  look.pitch_rad = 0.1;
  look.seen = std::move(seen);
  return look;
}

}  // namespace

TEST_CASE("a robot that starts again has the looks of all its earlier starts, in order, once") {
  const Folder folder;
  const mission::Mission m = small_mission();
  const RobotId explorer{1};
  for (int start = 1; start <= 3; ++start) {
    Robot robot(m, explorer, std::make_unique<Looking>(), static_cast<std::uint64_t>(start));
    robot.keep(std::make_unique<store::Journal>(journal_file(folder, explorer), explorer,
                                                store::Journal::Durability::kProcess));
    mission::StepInput input{.tick = 1, .now = time_of_tick(1), .bus = {}, .air = {}};
    input.bus = {dds::encode(look(start, {{{4, 1, 2}, 3, 2, 1}})), dds::encode(look(-start, {}))};
    robot.step(input);
    const std::vector<Look>& looks = robot.knowledge().looks();
    REQUIRE(looks.size() == 2 * static_cast<std::size_t>(start));
    for (int i = 1; i <= start; ++i) {
      const auto& [explored, kept] = looks[2 * static_cast<std::size_t>(i - 1)];
      CHECK(explored == RegionId{0});
      CHECK(kept.sensor.p == Vec3(i, 0, 1));
      CHECK(kept.sensor.yaw_rad == 0.5);
      CHECK(kept.pitch_rad == 0.1);
      REQUIRE(kept.seen.size() == 1);
      CHECK(kept.seen[0].position == Vec3(4, 1, 2));
    }
  }
}

TEST_CASE("looks that were told count for others, and for who told them when its journal is lost") {
  const Folder folder;
  const mission::Mission m = small_mission();
  const RobotId explorer{1}, other{2};
  Knowledge before(m, explorer, 1), friendly(m, other, 1);
  mission::Status told;
  told.kind = mission::StatusKind::kLooks;
  told.looks = {{{1, 2, 3}, 0.5}, {{2, 2, 3}, 0.5}};
  before.publish(store::RecordClass::kRequest, 7, told);
  CHECK(before.told_looks().empty());
  pass(before, friendly, store::RecordClass::kRequest);
  CHECK(friendly.told_looks().size() == 2);
  {
    auto file = journal(folder, explorer);
    file.keep_look(RegionId{0}, dds::encode(look(1, {})).cdr);
    file.commit(before.store());
  }
  auto file = journal(folder, explorer);
  Knowledge kept(m, explorer, 2), blank(m, explorer, 2);
  kept.restore(file);
  for (Knowledge* k : {&kept, &blank}) pass(friendly, *k, store::RecordClass::kRequest);
  CHECK(kept.looks().size() == 1);
  CHECK(kept.told_looks().empty());
  CHECK(blank.told_looks().size() == 2);
}

TEST_CASE("a kept look that cannot be read is left out") {
  const Folder folder;
  const mission::Mission m = small_mission();
  const RobotId explorer{1};
  {
    Knowledge before(m, explorer, 1);
    auto file = journal(folder, explorer);
    file.keep_look(RegionId{0}, {1, 2, 3});
    file.keep_look(RegionId{0}, dds::encode(look(1, {})).cdr);
    file.commit(before.store());
  }
  auto file = journal(folder, explorer);
  Knowledge after(m, explorer, 2);
  after.restore(file);
  REQUIRE(after.looks().size() == 1);
  CHECK(after.looks()[0].sightings.sensor.p == Vec3(1, 0, 1));
}

TEST_CASE("a robot that starts again knows what it knew: areas, results, its own map") {
  const Folder folder;
  const mission::Mission m = small_mission();
  const RobotId explorer{1}, inspector{2};
  const Vec3 seen(-3, 0, 1);
  mission::AreaRef ref{explorer, 0};
  {
    Knowledge before(m, explorer, 1);
    auto file = journal(folder, explorer);
    ref.key = before.store().new_key(store::RecordClass::kArea);
    before.publish(store::RecordClass::kArea, ref.key, area_at({3, 1, 2}));
    Knowledge other(m, inspector, 1);
    mission::Inspection result;
    result.area = ref;
    result.found = true;
    other.publish(store::RecordClass::kInspection, result_key(ref), result);
    before.receive(
        inspector, 1,
        *other.store().find(inspector, store::RecordClass::kInspection, result_key(ref)));
    const map::BlockKey block = map::block_of(before.map().key(seen));
    file.keep_block(map::pack(block),
                    map::encode_blocks(std::array{before.map().own_block(block)}));
    file.commit(before.store());
  }
  auto file = journal(folder, explorer);
  CHECK(file.epoch() == 1);
  mission::Mission elsewhere = m;
  elsewhere.fleet[1].start.p = {-12, -12, 1};  // where it starts, it knows anyhow
  Knowledge after(elsewhere, explorer, file.epoch() + 1);
  REQUIRE(after.map().at(seen) == map::Voxel::kUnknown);
  after.restore(file);
  REQUIRE(after.areas().contains(ref));
  CHECK(after.areas().at(ref).area.position == Vec3(3, 1, 2));
  CHECK(after.inspected(ref));
  CHECK(after.map().at(seen) == map::Voxel::kFree);
  CHECK(after.store().new_key(store::RecordClass::kArea) != ref.key);
}

TEST_CASE(
    "a robot that came down through what it took for an obstacle knows that nothing is there") {
  const Folder folder;
  const mission::Mission m = small_mission();
  const RobotId explorer{1};
  const Vec3 p(4.1, 3.1, 0.26), obstacle = p + Vec3(0, 0, 0.7), beside = p + Vec3(1, 0, 0.7);
  {
    Knowledge before(m, explorer, 1);
    const map::BlockKey block = map::block_of(before.map().key(obstacle));
    std::vector<map::Voxel> voxels(map::kBlockVoxels, map::Voxel::kFree);
    for (const Vec3& q : {obstacle, beside})
      voxels.at(static_cast<std::size_t>(map::local_index(before.map().key(q)))) =
          map::Voxel::kOccupied;
    before.map().adopt_own(map::said(block, voxels));
    auto file = journal(folder, explorer);
    file.keep_block(map::pack(block),
                    map::encode_blocks(std::array{before.map().own_block(block)}));
    file.commit(before.store());
  }
  Robot robot(m, explorer, std::make_unique<Looking>(), 2);
  robot.keep(std::make_unique<store::Journal>(journal_file(folder, explorer), explorer,
                                              store::Journal::Durability::kProcess));
  const map::VoxelMap& map = robot.knowledge().map();
  REQUIRE(map.at(map.key(obstacle)) == map::Voxel::kOccupied);
  mission::Odometry odometry;
  odometry.pose.p = p;
  robot.step({.tick = 1, .now = time_of_tick(1), .bus = {dds::encode(odometry)}, .air = {}});
  CHECK(map.at(map.key(obstacle)) == map::Voxel::kFree);
  CHECK(map.at(map.key(beside)) == map::Voxel::kOccupied);
}

TEST_CASE("own map blocks of an earlier start that come back by radio are own evidence again") {
  const mission::Mission m = small_mission();
  const RobotId explorer{1};
  const Vec3 seen(-3, 0, 1);
  Knowledge before(m, explorer, 1);
  const map::BlockKey b = map::block_of(before.map().key(seen));
  const std::uint64_t key = before.store().new_key(store::RecordClass::kMap);
  before.publish(store::RecordClass::kMap, key,
                 dds::map_block(std::array{before.map().own_block(b)}, 0.2));

  mission::Mission elsewhere = m;
  elsewhere.fleet[1].start.p = {-12, -12, 1};
  Knowledge after(elsewhere, explorer, 2);
  after.receive(RobotId{2}, 1, *before.store().find(explorer, store::RecordClass::kMap, key));
  CHECK(after.map().at(seen) == map::Voxel::kFree);
  std::uint64_t cursor = 0;
  CHECK_FALSE(after.map().own_changes(cursor).empty());
  CHECK_FALSE(after.map().news(b));  // it has said so itself
}
