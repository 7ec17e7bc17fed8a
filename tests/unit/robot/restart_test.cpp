#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "common/dds/map_block.h"
#include "common/map/block_codec.h"
#include "tests/unit/robot/fixtures.h"

using namespace muster;
using namespace muster::robot;
namespace fs = std::filesystem;

namespace {

struct Folder {
  ~Folder() { fs::remove_all(dir); }
  fs::path dir = fs::temp_directory_path() / fmt::format("muster_restart_{}", getpid());
};

store::Journal journal(const Folder& folder, RobotId robot) {
  return {store::Journal::path(folder.dir, robot), robot, store::Journal::Durability::kProcess};
}

mission::Area area_at(const Vec3& p) {
  mission::Area area;
  area.position = p;
  return area;
}

}  // namespace

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
