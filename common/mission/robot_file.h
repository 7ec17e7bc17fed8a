#pragma once

#include <string>
#include <vector>

#include "common/core/ids.h"

namespace muster::mission {

/// One robot's place in a real fleet: `/etc/muster/<id>.yaml`, read by `muster-agent --config` and
/// `muster-gcs --config`. What the mission says about the robot is not repeated here; this is only
/// what differs from computer to computer.
struct RobotFile {
  std::string file;                ///< where it was read from
  std::string mission_file;        ///< `mission`: absolute, or relative to this file
  RobotId id;                      ///< `id`
  std::string dds = "cyclonedds";  ///< vendor, as `dds::vendor_from` takes it
  std::string profile = "wired";   ///< as `dds::profile_from` takes it: "wired" or "wifi-unicast"
  std::string network_interface;   ///< `interface`: name or address; empty: the vendor's choice
  std::vector<std::string> peers;  ///< static peers; wifi-unicast needs them
  std::string link = "direct";     ///< as `dds::link_from` takes it; "radio" in a lab
  std::uint32_t domain = 60;       ///< air, below 100
  std::uint32_t bus_domain = 61;   ///< never leaves this computer, below 100
  std::string state_dir;           ///< default: /var/lib/muster/<id>

  /// Reads and checks what can be checked without the network or the mission. Throws BadInput:
  /// `file:line: key: …`.
  static RobotFile load(const std::string& path);
};

}  // namespace muster::mission
