#include "common/dds/robot_shell.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"

using namespace muster;
using dds::RobotShellOptions;
namespace fs = std::filesystem;

namespace {

/// A robot's file, as /etc/muster holds one.
class RobotsFile {
 public:
  explicit RobotsFile(const std::string& text) { std::ofstream(path_) << text; }
  ~RobotsFile() { fs::remove(path_); }
  std::string path() const { return path_; }

 private:
  fs::path path_ =
      fs::temp_directory_path() / ("muster_robot_" + std::to_string(getpid()) + ".yaml");
};

}  // namespace

TEST_CASE("a robot in the field takes everything from its file") {
  const RobotsFile file(
      "mission: m.yaml\nid: 3\ndds: fastdds\nprofile: wifi-unicast\ninterface: wlan0\n"
      "peers: [10.0.0.1, 10.0.0.2]\nlink: radio\ndomain: 50\nbus_domain: 52\nstate_dir: "
      "/tmp/state\n");
  const RobotShellOptions o = RobotShellOptions::from_file(file.path());
  CHECK(o.field);
  CHECK(o.mission_file == (fs::path(file.path()).parent_path() / "m.yaml").string());
  CHECK(o.id == 3);
  CHECK(o.vendor == "fastdds");
  CHECK(o.profile == "wifi-unicast");
  CHECK(o.network_interface == "wlan0");
  CHECK(o.peers == std::vector<std::string>{"10.0.0.1", "10.0.0.2"});
  CHECK(o.link == "radio");
  CHECK(o.air_domain == 50);
  CHECK(o.domain == 52);
  CHECK(o.out == "/tmp/state");
  CHECK_NOTHROW(o.validate());
}

TEST_CASE("a short file means a wired robot with the usual domains and its own state folder") {
  const RobotsFile file("mission: /m.yaml\nid: 3\n");
  const RobotShellOptions o = RobotShellOptions::from_file(file.path());
  CHECK(o.profile == "wired");
  CHECK(o.air_domain != o.domain);
  CHECK(o.out == "/var/lib/muster/3");
}

TEST_CASE("what is wrong in a robot's file is told with its line and key") {
  const RobotsFile file("mission: /m.yaml\nid: 3\ndds: opendds\n");
  try {
    RobotShellOptions::from_file(file.path());
    FAIL("was taken");
  } catch (const BadInput& e) {
    CHECK(std::string(e.what()).starts_with(file.path() + ":3: dds: 'opendds' is not a vendor"));
  }
}

TEST_CASE("a robot that does not know who or where it is does not start") {
  RobotShellOptions o;
  o.mission_file = "m.yaml", o.id = 3, o.domain = 40;
  CHECK_NOTHROW(o.validate());
  const auto refused = [&](const auto& change) {
    RobotShellOptions changed = o;
    change(changed);
    CHECK_THROWS_AS(changed.validate(), BadInput);
  };
  refused([](RobotShellOptions& c) { c.mission_file.clear(); });
  refused([](RobotShellOptions& c) { c.id.reset(); });
  refused([](RobotShellOptions& c) { c.domain.reset(); });
  refused([](RobotShellOptions& c) { c.vendor = "opendds"; });
  refused([](RobotShellOptions& c) { c.profile = "pigeon"; });
  refused([](RobotShellOptions& c) { c.link = "string"; });
  refused([](RobotShellOptions& c) { c.speed = 0; });
}
