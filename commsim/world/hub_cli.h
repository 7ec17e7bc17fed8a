#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "commsim/world/hub_options.h"

namespace muster::world {

/// Adds the options that both hubs take. `out_is` says what goes to --out. Header-only, so that
/// only programs need CLI11.
inline void add_hub_options(CLI::App& app, HubOptions& options, const std::string& out_is) {
  app.add_option("--mission", options.mission_file, "mission file")->required();
  app.add_option("--set", options.set, "KEY=VALUE: overrides a key of the mission file; repeatable")
      ->expected(1)
      ->take_all();
  app.add_option("--faults", options.faults, "file with a script of faults, besides the mission's");
  app.add_option("--domain", options.domain, "DDS domain of the bus; the radio is on the next one")
      ->required();
  app.add_option("--dds", options.vendor, "cyclonedds or fastdds")->capture_default_str();
  app.add_option("--out", options.out, out_is)->capture_default_str();
  app.add_option("--control-fd", options.control_fd, "socket on which `muster run` talks to us");
}

}  // namespace muster::world
