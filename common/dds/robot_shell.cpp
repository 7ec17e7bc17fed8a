#include "common/dds/robot_shell.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/core/program.h"
#include "common/dds/field.h"
#include "common/dds/lockstep.h"
#include "common/dds/own_clock.h"
#include "common/mission/robot_file.h"

namespace muster::dds {
namespace {

volatile std::sig_atomic_t g_stop = 0;

void stop_on_signal() {
  for (int signal : {SIGTERM, SIGINT}) {
    std::signal(signal, [](int) { g_stop = 1; });
  }
}

std::uint64_t epoch_of(const RobotShellOptions& options) {
  if (options.epoch) return *options.epoch;
  if (!options.field) return 1;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
}

/// In the barrier.
Life life_of(const RobotShellOptions& options) {
  return static_cast<Life>(options.epoch.value_or(kFirstLife));
}

/// A robot without a disk flies all the same.
std::unique_ptr<store::Journal> open_journal(const RobotShellOptions& options, RobotId self) {
  using store::Journal;
  try {
    return std::make_unique<Journal>(
        Journal::path(options.out, self), self,
        options.field ? Journal::Durability::kPower : Journal::Durability::kProcess);
  } catch (const Failure& e) {
    log::error("{}; flying on, but nothing is kept", e.what());
    return nullptr;
  }
}

std::string run_in_field(const RobotShellOptions& options, mission::Process& process,
                         bool station) {
  FieldConfig config;
  config.self = process.id();
  config.station = station;
  config.vendor = vendor_from(options.vendor);
  config.bus_domain = *options.domain;
  config.air_domain = options.air_domain.value_or(*options.domain + 1);
  config.air_profile =
      options.profile.empty() ? Profile::kSimLocalhost : profile_from(options.profile);
  config.network_interface = options.network_interface;
  config.peers = options.peers;
  config.link = link_from(options.link);
  config.speed = options.speed;
  FieldRunner runner(config);
  runner.run([&](const mission::StepInput& input) { return process.step(input); }, g_stop);
  return "asked to stop";
}

std::string run_in_barrier(const RobotShellOptions& options, const mission::Mission& mission,
                           mission::Process& process, store::Journal* journal) {
  const RobotId self = process.id();
  const bool station = mission.robot(self).role == mission::Role::kStation;
  RobotLockstep barrier(BarrierConfig::from(vendor_from(options.vendor), *options.domain), self,
                        station, life_of(options));
  const auto step = [&](const mission::StepInput& input) {
    if (journal)
      journal->set_disk_full(mission::in_force(mission.script, "full-disk", self, input.now));
    return process.step(input);
  };
  return barrier.run(step, g_stop);
}

}  // namespace

RobotShellOptions RobotShellOptions::from_file(const std::string& path) {
  const mission::RobotFile file = mission::RobotFile::load(path);
  RobotShellOptions o;
  o.field = true;
  o.mission_file = file.mission_file;
  o.id = file.id.value;
  o.vendor = file.dds;
  o.profile = file.profile;
  o.network_interface = file.network_interface;
  o.peers = file.peers;
  o.link = file.link;
  o.air_domain = file.domain;
  o.domain = file.bus_domain;
  o.out = file.state_dir;
  return o;
}

void RobotShellOptions::validate() const {
  if (mission_file.empty()) throw BadInput("--mission: a mission file is needed");
  if (!id) throw BadInput("--id: which robot of the mission this is");
  if (!domain) throw BadInput("--domain: the DDS domain of the bus is needed");
  vendor_from(vendor);
  if (!profile.empty()) profile_from(profile);
  link_from(link);
  if (!(speed > 0)) throw BadInput("--speed: must be above 0");
}

std::string RobotShellOptions::to_yaml() const {
  return fmt::format(
      "mission: {}\nid: {}\ndds: {}\nprofile: {}\ninterface: {}\npeers: [{}]\nlink: {}\ndomain: "
      "{}\nbus_domain: {}\nstate_dir: {}\n",
      mission_file, *id, vendor, profile.empty() ? "sim-localhost" : profile,
      network_interface.empty() ? "\"\"" : network_interface, fmt::join(peers, ", "), link,
      air_domain.value_or(*domain + 1), *domain, out);
}

int run_robot(const RobotShellOptions& options, bool station, const MakeProcess& make_process) {
  end_with_launcher();
  options.validate();
  const mission::Mission mission =
      mission::Mission::load(options.mission_file, options.set, options.faults);
  const RobotId self{*options.id};
  if (!mission.has(self))
    throw BadInput(fmt::format("--id: the mission has no robot {}", self.value));
  if ((mission.robot(self).role == mission::Role::kStation) != station) {
    throw BadInput(
        fmt::format("--id: robot {} is {}", self.value,
                    station ? "not a station: use muster-agent" : "a station: use muster-gcs"));
  }
  // Before the first trace of this process: who sees its log may ask it to stop.
  stop_on_signal();
  std::error_code error;
  std::filesystem::create_directories(options.out + "/logs", error);
  log::open(
      options.out + "/logs", fmt::format("{}-{}", station ? "gcs" : "agent", self.value),
      !options.field && life_of(options) > kFirstLife ? log::Before::kKeep : log::Before::kForget);
  std::unique_ptr<store::Journal> journal = open_journal(options, self);
  const std::uint64_t after = journal ? journal->epoch() + 1 : 0;
  std::unique_ptr<mission::Process> process =
      make_process(mission.without_script(), self, std::max(epoch_of(options), after));
  if (!options.field) process = with_own_clock(std::move(process), mission);
  store::Journal* const kept = journal.get();  // the process owns it from here
  if (journal) process->keep(std::move(journal));
  try {
    const std::string reason = options.field ? run_in_field(options, *process, station)
                                             : run_in_barrier(options, mission, *process, kept);
    log::info("ended: {}", reason);
  } catch (const std::exception& e) {
    log::error("{}", e.what());
    process->finish(options.out);
    throw;
  }
  process->finish(options.out);
  return 0;
}

}  // namespace muster::dds
