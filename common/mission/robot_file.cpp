#include "common/mission/robot_file.h"

#include <filesystem>

#include "common/core/yaml.h"

namespace muster::mission {
namespace {

void check(const RobotFile& robot, const YamlMap& map) {
  if (robot.dds != "cyclonedds" && robot.dds != "fastdds")
    map.fail("dds", "'" + robot.dds + "' is not a vendor; use cyclonedds or fastdds");
  if (robot.profile != "wired" && robot.profile != "wifi-unicast")
    map.fail("profile", "'" + robot.profile +
                            "' is not a profile of a real network; use wired or wifi-unicast");
  if (robot.profile == "wifi-unicast" && robot.peers.empty())
    map.fail("peers", "wifi-unicast finds nobody by multicast; list the other robots' addresses");
  if (robot.link != "direct" && robot.link != "radio")
    map.fail("link", "'" + robot.link + "' is not direct, or radio as in a lab");
  // Above 99 the ports of a domain run into the ephemeral range.
  if (robot.domain >= 100) map.fail("domain", "must be below 100");
  if (robot.bus_domain >= 100) map.fail("bus_domain", "must be below 100");
  if (robot.domain == robot.bus_domain)
    map.fail("bus_domain", "must differ from domain, or what is said on board goes on air");
}

}  // namespace

RobotFile RobotFile::load(const std::string& path) {
  YamlMap map = YamlMap::load(path);
  RobotFile robot;
  robot.file = path;
  map.require("mission", robot.mission_file);
  map.require("id", robot.id.value);
  map.read("dds", robot.dds);
  map.read("profile", robot.profile);
  map.read("interface", robot.network_interface);
  map.read("peers", robot.peers);
  map.read("link", robot.link);
  map.read("domain", robot.domain);
  map.read("bus_domain", robot.bus_domain);
  map.read("state_dir", robot.state_dir);
  map.finish();
  if (robot.state_dir.empty())
    robot.state_dir = "/var/lib/muster/" + std::to_string(robot.id.value);
  check(robot, map);
  const std::filesystem::path mission = robot.mission_file;
  if (mission.is_relative())
    robot.mission_file =
        (std::filesystem::path(path).parent_path() / mission).lexically_normal().string();
  return robot;
}

}  // namespace muster::mission
