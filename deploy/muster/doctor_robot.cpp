#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "common/mission/mission.h"
#include "common/mission/robot_file.h"
#include "deploy/muster/doctor.h"

namespace muster::command {
namespace {

using Verdict = Check::Verdict;
using mission::Mission;
using mission::RobotFile;

constexpr const char* kTopic = "Robot";

Check check_identity(const RobotFile& robot, const Mission& mission) {
  const std::string id = std::to_string(robot.id.value);
  if (!mission.has(robot.id)) {
    std::string known;
    for (const auto& r : mission.fleet)
      known += (known.empty() ? "" : ", ") + std::to_string(r.id.value);
    return {kTopic, "robot " + id + " is not in the fleet of " + mission.name, Verdict::kBad,
            "the fleet is " + known};
  }
  const bool station = mission.robot(robot.id).role == mission::Role::kStation;
  return {kTopic,
          "robot " + id + " of mission " + mission.name +
              (station ? ", a station: muster-gcs@" : ": muster-agent@") + id,
          Verdict::kGood, ""};
}

/// Name or address, as configured; nullptr when this computer has no such interface.
const ifaddrs* find_interface(const ifaddrs* list, const std::string& wanted) {
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET) continue;
    char text[NI_MAXHOST] = "";
    getnameinfo(entry->ifa_addr, sizeof(sockaddr_in), text, sizeof text, nullptr, 0,
                NI_NUMERICHOST);
    if (wanted == entry->ifa_name || wanted == text) return entry;
  }
  return nullptr;
}

Check check_interface(const RobotFile& robot) {
  if (robot.network_interface.empty()) {
    return {kTopic, "no interface is named: the DDS vendor takes its choice", Verdict::kWarn,
            "name the one that leads to the other robots: `interface: wlan0`"};
  }
  ifaddrs* list = nullptr;
  getifaddrs(&list);
  const ifaddrs* entry = find_interface(list, robot.network_interface);
  Check check{kTopic, "interface " + robot.network_interface + " is up", Verdict::kGood, ""};
  if (!entry) {
    check = {kTopic, "there is no interface " + robot.network_interface + " with an IPv4 address",
             Verdict::kBad, "see the interfaces above"};
  } else if (!(entry->ifa_flags & IFF_UP)) {
    check = {kTopic, "interface " + robot.network_interface + " is down", Verdict::kBad,
             "ip link set " + robot.network_interface + " up"};
  } else if (robot.profile == "wired" && robot.peers.empty() &&
             !(entry->ifa_flags & IFF_MULTICAST)) {
    check = {kTopic,
             "interface " + robot.network_interface +
                 " has no multicast, and no peers are listed: nobody will be found",
             Verdict::kBad, "list `peers`"};
  }
  freeifaddrs(list);
  return check;
}

Checks check_peers(const RobotFile& robot) {
  Checks checks;
  for (const std::string& peer : robot.peers) {
    addrinfo hints{}, *found = nullptr;
    hints.ai_family = AF_INET;
    if (getaddrinfo(peer.c_str(), nullptr, &hints, &found) != 0) {
      checks.push_back({kTopic, "peer " + peer + " is neither an address nor a known name",
                        Verdict::kBad,
                        "names must be resolved without the network; use addresses"});
    } else {
      freeaddrinfo(found);
    }
  }
  if (checks.empty() && !robot.peers.empty())
    checks.push_back(
        {kTopic,
         std::to_string(robot.peers.size()) + (robot.peers.size() == 1 ? " peer" : " peers"),
         Verdict::kGood, ""});
  return checks;
}

/// Whether the one who runs agents (user `muster` where there is one, else whoever asks) can write
/// there.
bool writable(const std::string& folder) {
  struct stat info {};
  const passwd* user = getpwnam("muster");
  if (!user || geteuid() != 0) return access(folder.c_str(), W_OK) == 0;
  return stat(folder.c_str(), &info) == 0 && info.st_uid == user->pw_uid &&
         (info.st_mode & S_IWUSR);
}

Check check_state(const RobotFile& robot) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::is_directory(robot.state_dir, error)) {
    if (writable(robot.state_dir))
      return {kTopic, "state in " + robot.state_dir, Verdict::kGood, ""};
    return {kTopic,
            "state_dir " + robot.state_dir + " cannot be written: nothing would survive a restart",
            Verdict::kBad, "chown -R muster: " + robot.state_dir};
  }
  if (writable(fs::path(robot.state_dir).parent_path().string())) {
    return {kTopic, "state_dir " + robot.state_dir + " is made at the first start", Verdict::kGood,
            ""};
  }
  return {kTopic, "state_dir " + robot.state_dir + " is no folder", Verdict::kBad,
          "install -d -o muster " + robot.state_dir};
}

Check check_domains(const RobotFile& robot) {
  const std::vector<std::uint32_t> taken = taken_domains();
  const auto is_taken = [&](std::uint32_t d) {
    return std::find(taken.begin(), taken.end(), d) != taken.end();
  };
  std::string used;
  for (const std::uint32_t d : {robot.domain, robot.bus_domain}) {
    if (is_taken(d)) used += (used.empty() ? "" : " and ") + std::to_string(d);
  }
  if (used.empty())
    return {kTopic,
            "its DDS domains " + std::to_string(robot.domain) + " and " +
                std::to_string(robot.bus_domain) + " are free",
            Verdict::kGood, ""};
  return {kTopic,
          "its DDS domain " + used + " is in use here: right if the robot is running, wrong if not",
          Verdict::kNote, ""};
}

}  // namespace

Checks check_robot_file(const std::string& path) {
  const RobotFile robot = RobotFile::load(path);
  const Mission mission = Mission::load(robot.mission_file);
  Checks checks{check_identity(robot, mission), check_interface(robot), check_domains(robot),
                check_state(robot)};
  for (Check& peer : check_peers(robot)) checks.push_back(std::move(peer));
  return checks;
}

}  // namespace muster::command
