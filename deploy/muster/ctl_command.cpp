#include <fmt/format.h>

#include <memory>
#include <optional>

#include "deploy/muster/commands.h"
#include "deploy/muster/control_socket.h"

namespace muster::command {
namespace {

struct CtlOptions {
  std::string dir, verb;
  std::optional<std::uint32_t> robot;
};

}  // namespace

void add_ctl_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<CtlOptions>();
  CLI::App* ctl =
      app.add_subcommand("ctl", "Asks a running mission to hold, resume, return, land or abort");
  ctl->add_option("DIR", options->dir, "the run's output directory (--out)")->required();
  ctl->add_option("VERB", options->verb,
                  "hold: stop and stay. resume: go on. return: fly home and land. land: land here. "
                  "abort: everyone home")
      ->required();
  ctl->add_option("--robot", options->robot, "only this robot; without it, everyone");
  ctl->footer(
      "The request enters at the station and spreads over the radio like any record: a robot out "
      "of reach obeys when it hears it.\n\n"
      "  muster ctl runs/pagoda hold --robot 3\n  muster ctl runs/pagoda abort");
  ctl->callback([options, &action] {
    action = [options] {
      send_request(options->dir, options->verb,
                   options->robot ? RobotId{*options->robot} : kNoRobot);
      return 0;
    };
  });
}

}  // namespace muster::command
