#include "common/core/command_line.h"
#include "common/core/log.h"
#include "common/core/program.h"
#include "commsim/world/direct_runner.h"
#include "commsim/world/hub_cli.h"
#include "commsim/world/lockstep_runner.h"

namespace muster {
namespace {

int run(const world::RunnerOptions& options, bool direct) {
  end_with_launcher();
  log::open(options.out + "/logs", "world");
  return direct ? world::run_direct(options) : world::run_in_lockstep(options);
}

}  // namespace
}  // namespace muster

int main(int argc, char** argv) {
  return muster::run_program("muster-world", [&] {
    muster::world::RunnerOptions options;
    bool direct = false;
    CLI::App app{
        "muster-world: the place. Moves the vehicles, makes their sensors' measurements, owns the "
        "clock, and judges the mission by the rules. Started by `muster run`; in the field drivers "
        "take its place."};
    muster::world::add_hub_options(
        app, options, "directory for events.jsonl, tracks.csv, features.csv and logs/");
    app.add_option("--duration", options.duration_s,
                   "end after this many simulated seconds; 0: when the mission ends");
    app.add_option("--speed", options.speed, "times real time; 0: as fast as everyone can");
    app.add_option("--restart", options.restart_s,
                   "a robot whose process ended by itself is started again after this many "
                   "simulated seconds; 0: never");
    app.add_flag("--trace", options.trace,
                 "write trace.csv: per tick, what each process's part of the trace was");
    app.add_flag("--direct", direct, "no barrier: everyone on their own clock, as in the field");
    return muster::parse_command_line(app, argc, argv) ? muster::run(options, direct) : 0;
  });
}
