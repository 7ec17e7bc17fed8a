#include <CLI/CLI.hpp>
#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/core/log.h"
#include "common/core/program.h"
#include "commsim/world/direct_runner.h"
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
  muster::world::RunnerOptions options;
  bool direct = false;
  CLI::App app{
      "muster-world: the place. Moves the vehicles, makes their sensors' measurements, owns the "
      "clock, and judges the mission by the "
      "rules. Started by `muster run`; in the field drivers take its place."};
  app.add_option("--mission", options.mission_file, "mission file")->required();
  app.add_option("--set", options.set, "KEY=VALUE: overrides a key of the mission file; repeatable")
      ->expected(1)
      ->take_all();
  app.add_option("--domain", options.domain, "DDS domain of the bus; the radio is on the next one")
      ->required();
  app.add_option("--dds", options.vendor, "cyclonedds or fastdds")->capture_default_str();
  app.add_option("--out", options.out,
                 "directory for events.jsonl, tracks.csv, features.csv and logs/")
      ->capture_default_str();
  app.add_option("--duration", options.duration_s,
                 "end after this many simulated seconds; 0: when the mission ends");
  app.add_option("--speed", options.speed, "times real time; 0: as fast as everyone can");
  app.add_flag("--trace", options.trace,
               "write trace.csv: per tick, what each process's part of the trace was");
  app.add_flag("--direct", direct, "no barrier: everyone on their own clock, as in the field");
  app.add_option("--control-fd", options.control_fd, "socket on which `muster run` talks to us");
  CLI11_PARSE(app, argc, argv);
  return muster::run_program("muster-world", [&] { return muster::run(options, direct); });
}
