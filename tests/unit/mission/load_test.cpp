#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "tests/unit/mission/folder.h"

using namespace muster;
using namespace muster::mission::testing;
using mission::Mission;
namespace fs = std::filesystem;

namespace {

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("a short mission gives each robot its own id, start and vehicle") {
  const Folder folder;
  const Mission m = folder.load(kGood);
  REQUIRE(m.fleet.size() == 4);
  CHECK(m.station() == RobotId{1});
  CHECK(m.robot(RobotId{4}).start.p.isApprox(Vec3(2, 8, 1)));
  CHECK(m.robot(RobotId{2}).start.yaw_rad == Approx(std::numbers::pi / 2));
  CHECK(m.robot(RobotId{3}).vehicle.name == "quad");
  CHECK(m.robot(RobotId{1}).vehicle.ground);
  CHECK(m.seed == 4);
  CHECK(m.standing.t0 == Duration::from_s(100));
}

TEST_CASE("the effective mission reads back as itself") {
  const Folder folder;
  const Mission m = folder.load(kGood + "script: [{at_s: 60, verb: kill, robot: 3}]\n");
  const std::string text = m.to_yaml();
  CHECK(folder.load(text).to_yaml() == text);
  CHECK(text.find("vfov_deg: 47.3") != std::string::npos);
}

TEST_CASE("set changes one value and what it says is checked") {
  const Folder folder;
  const Mission m = folder.load(
      kGood, {"inspect.hold_s=5", "radio.range_m=6", "seed=3", "vehicles.quad.speed_mps=1.5"});
  CHECK(m.inspect.hold_s == 5);
  CHECK(m.radio.range_m == 6);
  CHECK(m.seed == 3);
  CHECK(m.robot(RobotId{2}).vehicle.speed_mps == 1.5);
  CHECK(m.robot(RobotId{2}).vehicle.camera.hfov_rad == Approx(80 * std::numbers::pi / 180));
  CHECK(folder.complaint(kGood, {"inspect.hold=5"})
            .starts_with("--set inspect.hold=5: inspect.hold: unknown key; known here:"));
  CHECK(folder.complaint(kGood, {"radio.range_m=-1"}) ==
        "--set radio.range_m=-1: radio.range_m: must be greater than 0");
  CHECK(folder.complaint(kGood, {"seed"}) == "--set seed: 'key=value' is expected");
  CHECK(folder.complaint(kGood, {"fleet.7.first_id=9"}) ==
        "--set fleet.7.first_id=9: '7' is no index of a list of 3");
}

TEST_CASE("every mistake in a mission is one line with file, line and key") {
  const Folder folder;
  const auto with = [&](const std::string& from, const std::string& to) {
    return folder.complaint(replaced(kGood, from, to));
  };
  CHECK(folder.complaint(kGood) == "none");
  CHECK(with("seed: 4", "sead: 4").starts_with("m.yaml:10: sead: unknown key; known here:"));
  CHECK(with("seed: 4", "seed: many") == "m.yaml:10: seed: 'many' is not a number that fits here");
  CHECK(with("seed: 4", "seed: -1") == "m.yaml:10: seed: '-1' is not a number that fits here");
  CHECK(with("seed: 4", "strategy: slay3d") ==
        "m.yaml:10: strategy: 'slay3d' is not one of slei3d");
  CHECK(with("seed: 4", "sensing: {sighting_rate_hz: -2}") ==
        "m.yaml:10: sensing.sighting_rate_hz: must be greater than 0");
  CHECK(with("scene: place.yaml\n", "").find("'scene' is missing") != std::string::npos);
  CHECK(with("place.yaml", "nowhere.stl") == "m.yaml:1: scene: there is no file 'nowhere.stl'");
  CHECK(with("high: [5, 5, 8]", "high: [5, 50, 8]") ==
        "m.yaml:4: boxes[0]: the box reaches outside the hull");
  CHECK(with("high: [5, 5, 8]", "high: [5, -6, 8]") ==
        "m.yaml:4: boxes[0].high: must be above `low` in x, y and z");
  CHECK(with("high: [5, 5, 8]", "high: [5, .nan, 8]") == "m.yaml:4: boxes[0].high: must be finite");
  CHECK(with("first_id: 3", "first_id: 2") ==
        "m.yaml:8: fleet[2].first_id: robot 2 is there twice");
  CHECK(with("role: station", "role: explorer").ends_with(": a fleet needs a station"));
  CHECK(with("role: station", "role: boss") ==
        "m.yaml:6: fleet[0].role: 'boss' is not one of station, explorer, inspector");
  CHECK(with("[0, 8.5, 1, 90]", "[0, 18, 1]") ==
        "m.yaml:7: fleet[1].starts: robot 2 starts outside the hull");
  CHECK(with("[0, 8.5, 1, 90]", "[0, 8.5]") ==
        "m.yaml:7: fleet[1].starts: each is [x, y, z] or [x, y, z, yaw_deg]");
  CHECK(with("[2, 8, 1]", "[-2, 8.1, 1]") == "m.yaml:8: fleet[2].starts: robots 3 and 4 touch");
  CHECK(with("vehicle: cart", "vehicle: chariot") ==
        "m.yaml:6: fleet[0].vehicle: there is no vehicle file 'chariot'");
  CHECK(with("place: [0, 8, 1]", "place: [0, 80, 1]") ==
        "m.yaml:9: standing.place: is outside the hull");
  CHECK(folder.complaint("scene: [\n").starts_with("m.yaml:2: not YAML"));
  CHECK(folder.complaint("- a\n") == "m.yaml:1: a mapping 'key: value' is expected here");
}

TEST_CASE("a mistake in a vehicle file names that file") {
  const Folder folder;
  folder.write("quad.yaml", "radius_m: 0.25\nspeed_mps: 0\n");
  CHECK(folder.complaint(kGood) == "quad.yaml:2: speed_mps: must be greater than 0");
  folder.write("quad.yaml", "radius_m: 0.25\ncamera: {hfov: 80}\n");
  CHECK(folder.complaint(kGood).starts_with("quad.yaml:2: camera.hfov: unknown key"));
}

TEST_CASE("scripted events name robots that exist") {
  const Folder folder;
  CHECK(folder.complaint(kGood + "script: [{at_s: 60, verb: kill, robot: 9}]\n") ==
        "m.yaml:11: script[0].robot: there is no robot 9");
  CHECK(folder.complaint(kGood + "script: [{at_s: 60, verb: kill}]\n") ==
        "m.yaml:11: script[0]: 'robot' is missing");
  CHECK(folder.load(kGood + "script: [{at_s: 60, verb: abort}]\n").script.at(0).robot == kNoRobot);
}
