#include "common/core/command_line.h"
#include "common/core/program.h"
#include "deploy/muster/air.h"
#include "deploy/muster/commands.h"
#include "deploy/muster/doctor.h"
#include "deploy/muster/report.h"
#include "deploy/muster/scene_command.h"

int main(int argc, char** argv) {
  using namespace muster;
  return run_program("muster", [&] {
    CLI::App app{
        "muster: fleets that explore a site, inspect what they find, meet, and bring it home"};
    app.require_subcommand(1);
    app.get_formatter()->column_width(28);
    app.set_version_flag("--version", MUSTER_VERSION);
    command::Action action;
    command::add_run_command(app, action);
    command::add_ctl_command(app, action);
    command::add_lab_command(app, action);
    command::add_report_command(app);
    command::add_air_command(app);
    command::add_scene_command(app);
    command::add_doctor_command(app);
    // Commands that end where they are parsed throw from here as well.
    return parse_command_line(app, argc, argv) && action ? action() : 0;
  });
}
