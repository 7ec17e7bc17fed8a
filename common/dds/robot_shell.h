#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/mission/mission.h"
#include "common/mission/process.h"

namespace muster::dds {

/// How `muster-agent` or `muster-gcs` is asked to run: by flags (in simulation), by its file in
/// /etc/muster (in the field), or both: flags win.
struct RobotShellOptions {
  std::string mission_file;
  std::vector<std::string> set;
  std::string faults;  ///< a file with more of a script; empty: none
  std::optional<std::uint32_t> id;
  /// Larger at every start of this robot; default: 1 in lock-step, the system clock in ms in the
  /// field.
  std::optional<std::uint64_t> epoch;
  std::string vendor = "cyclonedds";
  std::optional<std::uint32_t>
      domain;  ///< bus; the air is the next one unless `air_domain` says otherwise
  std::optional<std::uint32_t> air_domain;
  std::string profile;  ///< of the air in the field; empty: sim-localhost
  std::string network_interface;
  std::vector<std::string> peers;
  std::string link = "direct";  ///< in the field: "direct", or "radio" in a lab (dds::Link)
  std::string out = ".";        ///< results and logs
  double speed = 1;
  bool field = false;  ///< own clock, no barrier

  /// Takes /etc/muster/<id>.yaml (mission::RobotFile). Implies `field`.
  static RobotShellOptions from_file(const std::string& path);
  /// Throws BadInput when something needed is missing.
  void validate() const;
  std::string to_yaml() const;
};

using MakeProcess = std::function<std::unique_ptr<mission::Process>(const mission::Mission&,
                                                                    RobotId, std::uint64_t epoch)>;

/// The whole shell of a robot's process: loads the mission, makes the robot, moves bytes between it
/// and DDS until the end, lets it write its files. `station`: whether this program is for stations.
/// Returns the exit status.
int run_robot(const RobotShellOptions& options, bool station, const MakeProcess& make_process);

}  // namespace muster::dds
