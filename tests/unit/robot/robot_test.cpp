#include "common/robot/robot.h"

#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "common/dds/map_block.h"
#include "common/store/database.h"
#include "tests/unit/robot/fixtures.h"

using namespace muster;
using namespace muster::robot;
namespace fs = std::filesystem;

namespace {

constexpr RobotId kSelf{1}, kOther{2}, kNewcomer{0};

/// A robot in its first tick, at `p`.
std::unique_ptr<Robot> started_at(const mission::Mission& m, const Vec3& p) {
  auto robot = std::make_unique<Robot>(m, kSelf, std::make_unique<Idle>(), 2);
  mission::Odometry odometry;
  odometry.pose.p = p;
  mission::StepInput input{.tick = 1, .now = time_of_tick(1), .bus = {}, .air = {}};
  input.bus.push_back(dds::encode(odometry));
  robot->step(input);
  return robot;
}

mission::Message beacon_of_newcomer(SimTime now, std::uint64_t n) {
  mission::Beacon b;
  b.envelope = {n, kNewcomer, mission::MessageClass::kBeacon, now};
  b.mission_time = now;
  b.epoch = 1;
  b.digest_n = n;  // it holds nothing
  return dds::encode(b);
}

mission::Message part_of_image() {
  mission::Inspection part;
  part.area = {kSelf, 1};
  part.part = 1;
  part.parts = 2;
  part.payload.assign(5000, 7);
  const store::RecordHeader header{
      {kOther, 1}, store::RecordClass::kImage, image_key(part.area, 1), 1, {}, {}};
  return dds::wrap({1, kOther, mission::MessageClass::kInspection, {}},
                   dds::encode_record(header, part));
}

/// How many image parts a robot passes on to somebody who has none, in 3 s; `then` is called once
/// its journal has what it heard.
int parts_sent_on(const std::function<void(const std::string& journal)>& then) {
  const fs::path dir = fs::temp_directory_path() / ("muster_robot_" + std::to_string(getpid()));
  const std::string file = (dir / "1.db").string();
  const mission::Mission m = small_mission();
  Robot robot(m, kSelf, std::make_unique<Idle>(), 1);
  robot.keep(std::make_unique<store::Journal>(file, kSelf, store::Journal::Durability::kProcess));
  int parts = 0;
  for (std::uint64_t k = 1; k <= 30; ++k) {
    mission::StepInput input{.tick = k, .now = time_of_tick(k), .bus = {}, .air = {}};
    if (k == 1) input.air.push_back(part_of_image());
    if (k == 2) then(file);
    if (k > 2 && k % 5 == 0) input.air.push_back(beacon_of_newcomer(input.now, k));
    for (const mission::Message& message : robot.step(input).air)
      parts += message.cls == mission::MessageClass::kInspection ? 1 : 0;
  }
  fs::remove_all(dir);
  return parts;
}

}  // namespace

TEST_CASE(
    "a robot that starts where its map knows no way out supposes one upwards, and only there") {
  const mission::Mission m = small_mission();
  const Vec3 known = m.robot(kSelf).start.p, unknown = known + Vec3(0, 4, -0.7);
  for (const Vec3& at : {known, unknown}) {
    const auto robot = started_at(m, at);
    const map::VoxelMap& map = robot->knowledge().map();
    const bool supposed = at == unknown;
    CHECK((map.at(unknown + 0.5 * Vec3::UnitZ()) == map::Voxel::kFree) == supposed);
    CHECK(map.at(unknown + 2 * Vec3::UnitZ()) == map::Voxel::kUnknown);
  }
}

TEST_CASE("an image that is only on disk is passed on all the same") {
  CHECK(parts_sent_on([](const std::string&) {}) > 0);
}

TEST_CASE("a robot whose disk does not give an image back flies on without it") {
  const auto lose = [](const std::string& journal) {
    store::Database(journal).execute("DELETE FROM records");
  };
  CHECK(parts_sent_on(lose) == 0);
}

TEST_CASE("what a whole map would cost grows with what is known, and is what OctoMap would write") {
  const mission::Mission m = small_mission();
  Robot robot(m, kSelf, std::make_unique<Idle>(), 1);
  const mission::WholeMapBytes at_first = robot.whole_map_bytes();
  CHECK(at_first.packed > 20);
  CHECK(at_first.packed < 2000);
  Knowledge other(m, kOther, 1);
  other.map().insert_free_ball({5, 0, 3}, 3);
  const map::BlockKey b = map::block_of(other.map().key({5, 0, 3}));
  const mission::MapBlock block = dds::map_block(std::array{other.map().own_block(b)}, 0.2);
  const store::RecordHeader header{{kOther, 1}, store::RecordClass::kMap, map::pack(b), 1, {}, {}};
  robot.step({.tick = 1,
              .now = time_of_tick(1),
              .bus = {},
              .air = {dds::wrap({1, kOther, mission::MessageClass::kMapBlock, {}},
                                dds::encode_record(header, block))}});
  const mission::WholeMapBytes then = robot.whole_map_bytes();
  CHECK(then.packed > at_first.packed);
  const auto path = fs::temp_directory_path() / fmt::format("muster_whole_{}.bt", getpid());
  robot.knowledge().map().write_bt(path);
  const auto file = static_cast<double>(fs::file_size(path));
  fs::remove(path);
  CHECK(static_cast<double>(then.octree) > 0.8 * (file - 200));
  CHECK(static_cast<double>(then.octree) <= file);
}

TEST_CASE("who starts away from its start, and knows nothing, knows the way up that it came down") {
  const mission::Mission m = small_mission();
  const bool away = GENERATE(false, true);
  const Vec3 p = away ? Vec3(4, 3, 0.26) : Vec3(m.robot(kSelf).start.p);
  const auto robot = started_at(m, p);
  const map::VoxelMap& map = robot->knowledge().map();
  const Vec3 above = p + Vec3(0, 0, 0.4);
  CHECK(map.traversable(above));
  CHECK(map.traversable(Vec3(above + Vec3(0.6, 0, 0))) == !away);  // and no more than that
}
