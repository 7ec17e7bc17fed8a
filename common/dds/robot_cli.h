#pragma once

#include "common/core/command_line.h"
#include "common/core/program.h"
#include "common/dds/robot_shell.h"

namespace muster::dds {

/// `main` of muster-agent and muster-gcs. Header-only, so that only programs need CLI11.
inline int robot_main(int argc, char** argv, const char* name, const char* what, bool station,
                      const MakeProcess& make_process) {
  return run_program(name, [&] {
    RobotShellOptions flags;
    std::string config_file;
    bool print_config = false;
    CLI::App app{what};
    app.add_option("--config", config_file,
                   "this robot's file for the field (/etc/muster/<id>.yaml); flags win over it")
        ->check(CLI::ExistingFile);
    auto* mission = app.add_option("--mission", flags.mission_file, "mission file");
    auto* id = app.add_option("--id", flags.id, "which robot of the mission this is");
    app.add_option("--epoch", flags.epoch, "number of this start of the robot, larger every time");
    auto* domain =
        app.add_option("--domain", flags.domain, "DDS domain of the bus; the air is the next one");
    auto* vendor =
        app.add_option("--dds", flags.vendor, "cyclonedds or fastdds")->capture_default_str();
    auto* out = app.add_option("--out", flags.out, "directory for results and logs/")
                    ->capture_default_str();
    auto* profile = app.add_option("--transport-profile", flags.profile,
                                   "the air in the field: sim-localhost, wired or wifi-unicast");
    auto* interface = app.add_option("--interface", flags.network_interface,
                                     "network interface of the air, in the field");
    auto* peers =
        app.add_option("--peers", flags.peers, "addresses of the other robots, in the field")
            ->delimiter(',');
    auto* link =
        app.add_option("--link", flags.link,
                       "in the field: direct, the real radio decides who is heard; or radio, "
                       "`muster lab` does, by poses and walls")
            ->capture_default_str();
    app.add_option("--set", flags.set, "KEY=VALUE: overrides a key of the mission file; repeatable")
        ->expected(1)
        ->take_all();
    app.add_option("--faults", flags.faults,
                   "file with a script of faults, besides the mission's; only in simulation");
    app.add_option("--speed", flags.speed, "with --field and a simulated world: times real time");
    app.add_flag("--field", flags.field,
                 "own clock, no barrier: real drivers on the bus, or muster run --link direct");
    app.add_flag("--print-config", print_config, "print the effective configuration and end");
    if (!parse_command_line(app, argc, argv)) return 0;
    RobotShellOptions options = flags;
    if (!config_file.empty()) {
      options = RobotShellOptions::from_file(config_file);
      if (*mission) options.mission_file = flags.mission_file;
      if (*id) options.id = flags.id;
      if (*domain) options.domain = flags.domain;
      if (*vendor) options.vendor = flags.vendor;
      if (*out) options.out = flags.out;
      if (*profile) options.profile = flags.profile;
      if (*interface) options.network_interface = flags.network_interface;
      if (*peers) options.peers = flags.peers;
      if (*link) options.link = flags.link;
      options.set = flags.set;
      options.faults = flags.faults;
      options.speed = flags.speed;
      options.epoch = flags.epoch;
    }
    if (print_config) {
      options.validate();
      std::fputs(options.to_yaml().c_str(), stdout);
      return 0;
    }
    return run_robot(options, station, make_process);
  });
}

}  // namespace muster::dds
