#include "common/mission/robot_file.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"

using namespace muster;
using mission::RobotFile;

namespace {

std::string written(const std::string& text) {
  const auto dir = std::filesystem::temp_directory_path() / "muster_robot_file_test";
  std::filesystem::create_directories(dir);
  const std::string path = (dir / "7.yaml").string();
  std::ofstream(path) << text;
  return path;
}

std::string complaint(const std::string& text) {
  try {
    RobotFile::load(written(text));
  } catch (const BadInput& e) {
    return e.what();
  }
  return "";
}

const std::string kGood = "mission: site.yaml\nid: 7\n";

}  // namespace

TEST_CASE("the robot file that the package installs is valid") {
  const RobotFile robot = RobotFile::load(MUSTER_SOURCE_DIR "/deploy/packaging/etc/example.yaml");
  CHECK(robot.profile == "wifi-unicast");
  CHECK(robot.peers.size() == 3);
}

TEST_CASE("a mission named relative to the robot file is found beside it") {
  const std::string path = written(kGood);
  CHECK(RobotFile::load(path).mission_file ==
        std::filesystem::path(path).parent_path() / "site.yaml");
}

TEST_CASE("a robot file that cannot work is refused in one line that names the key") {
  CHECK_THAT(complaint("id: 7\n"), Catch::Contains("'mission' is missing"));
  CHECK_THAT(complaint(kGood + "colour: red\n"),
             Catch::Contains(":3:") && Catch::Contains("colour"));
  CHECK_THAT(complaint(kGood + "dds: opendds\n"),
             Catch::Contains("dds") && Catch::Contains("cyclonedds or fastdds"));
  CHECK_THAT(complaint(kGood + "profile: wifi-unicast\n"), Catch::Contains("peers"));
  CHECK_THAT(complaint(kGood + "link: string\n"), Catch::Contains(":3: link"));
  CHECK_THAT(complaint(kGood + "domain: 100\n"), Catch::Contains("below 100"));
  CHECK_THAT(complaint(kGood + "domain: 61\n"), Catch::Contains("must differ"));
  CHECK_THAT(complaint("mission: a\nid: -1\n"), Catch::Contains("id"));
}
