#include <cstdio>
#include <filesystem>
#include <memory>

#include "commsim/world/scene.h"
#include "commsim/world/site_check.h"
#include "deploy/muster/commands.h"
#include "deploy/muster/free_domain.h"
#include "deploy/muster/launcher.h"
#include "deploy/muster/run_memory.h"
#include "deploy/muster/run_options.h"

namespace muster::command {
namespace {

constexpr const char* kFooter = R"(Examples
  muster run deploy/missions/pagoda.yaml                        watch one explorer and three inspectors at a pagoda
  muster run deploy/missions/town.yaml --seed 7 --out runs/t7   another seed, files to runs/t7
  muster run deploy/missions/pagoda.yaml --transport memory     the same flight inside one process, faster, same trace
  muster run deploy/missions/town.yaml --set radio.preset=wifi-5ghz   a radio that fades and is shared, not 5 m and line of sight
  muster run deploy/missions/pagoda.yaml --faults storm.yaml    the same with kills, jams, cuts …: a file with a script:
  muster run deploy/missions/pagoda.yaml --link direct --speed 1 --duration 60   no simulated radio: as in the field
  muster run deploy/missions/pagoda.yaml --external 3           prints how to start robot 3 yourself (gdb, another terminal)

Files in --out: summary.json events.jsonl features.csv tracks.csv air.csv map.bt station.db report.html logs/
Exit status: 0 mission complete, 3 ended incomplete or declared complete falsely, 2 bad input, 1 anything else.)";

int run(RunOptions& options) {
  const mission::Mission mission =
      mission::Mission::load(options.mission_file, options.overrides(), options.faults);
  options.validate(mission);
  if (options.print_config) {
    std::fputs(mission.to_yaml().c_str(), stdout);
    return 0;
  }
  if (options.out.empty()) options.out = "runs/" + mission.name;
  // Children, and whoever starts one by hand, may be in another directory.
  options.mission_file =
      std::filesystem::absolute(options.mission_file).lexically_normal().string();
  if (!options.faults.empty())
    options.faults = std::filesystem::absolute(options.faults).lexically_normal().string();
  options.out = std::filesystem::absolute(options.out).lexically_normal().string();
  // Before anything is made or started.
  std::shared_ptr<const world::Scene> scene = world::Scene::load(mission);
  world::check_site(mission, *scene);
  if (options.transport == "dds") options.domain = free_domain(options.domain);
  options.out_is_new = prepare_output(options.out);
  if (options.transport == "memory") return run_in_memory(mission, scene, options);
  scene.reset();  // the world's process loads its own
  return run_over_dds(mission, options);
}

}  // namespace

void add_run_command(CLI::App& app, Action& action) {
  auto o = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Flies a mission and writes what came of it");
  command->add_option("MISSION", o->mission_file, "mission file (deploy/missions/*.yaml)")
      ->required();
  command->add_option("--strategy", o->strategy, "instead of the mission's");
  command->add_option("--seed", o->seed,
                      "instead of the mission's: same mission, seed and build give the same trace");
  command->add_option("--dds", o->dds, "who carries the messages; mixed: agents alternate")
      ->check(CLI::IsMember({"cyclonedds", "fastdds", "mixed"}))
      ->capture_default_str();
  command
      ->add_option("--transport", o->transport,
                   "dds: every robot a process; memory: all in this one")
      ->check(CLI::IsMember({"dds", "memory"}))
      ->capture_default_str();
  command
      ->add_option("--link", o->link,
                   "radio: simulated range and walls; direct: everyone hears everyone")
      ->check(CLI::IsMember({"radio", "direct"}))
      ->capture_default_str();
  command->add_option("--speed", o->speed, "max, or times real time")->capture_default_str();
  command
      ->add_option("--set", o->set,
                   "KEY=VALUE: overrides a key of the mission file (radio.range_m=8); repeatable")
      ->expected(1)
      ->take_all();
  command->add_option("--faults", o->faults,
                      "file with a script of faults, besides the mission's: kill, revive, pause, "
                      "jam, cut, loss, drain, blind, full-disk, skew, chaos (see the README)");
  command->add_flag("--print-config", o->print_config,
                    "print the mission with every key, as it would be flown, and end");
  command->add_option("--external", o->external, "robots that you start yourself, by id")
      ->delimiter(',');
  command->add_option("--out", o->out, "directory for the results (default: runs/<mission name>)");
  command->add_option("--domain", o->domain,
                      "DDS domain of the bus, the radio uses the next one (default: a free one)");
  command->add_option("--duration", o->duration_s, "stop after this many simulated seconds");
  command->add_option("--restart", o->restart_s,
                      "start a robot whose process died by itself again after this many simulated "
                      "seconds; it goes on with what its journal kept (default: never)");
  command->add_flag("--trace", o->trace,
                    "write trace.csv: compare two to see the tick and process where they part");
  command->add_flag("--capture", o->capture,
                    "write air.pcapng: all RTPS packets of this run, for Wireshark with "
                    "muster.lua (needs CAP_NET_RAW)");
  command->add_flag("--json", o->json, "one JSON object per line on stdout");
  command->add_flag("--report,!--no-report", o->report, "write report.html at the end (default)");
  command->footer(kFooter);
  command->callback([o, &action] { action = [o] { return run(*o); }; });
}

}  // namespace muster::command
