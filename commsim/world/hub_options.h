#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace muster::world {

/// What `muster run` tells both hubs of a simulated run, the world and the radio.
struct HubOptions {
  std::string mission_file, vendor = "cyclonedds", out = ".";
  std::vector<std::string> set;  ///< KEY=VALUE, over the mission file
  std::string faults;            ///< a file with more of a script; empty: none
  std::uint32_t domain = 0;      ///< of the bus; the radio is on the next one
  int control_fd = -1;           ///< −1: nobody started us
};

}  // namespace muster::world
