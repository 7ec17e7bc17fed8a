#include <atomic>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/core/command_line.h"
#include "common/core/line_channel.h"
#include "common/core/log.h"
#include "common/core/program.h"
#include "common/dds/lockstep.h"
#include "commsim/lab_radio.h"
#include "commsim/relay.h"
#include "commsim/world/hub_cli.h"

namespace muster {
namespace {

std::vector<RobotId> robots_of(const mission::Mission& mission) {
  std::vector<RobotId> all;
  for (const mission::RobotConfig& robot : mission.fleet) all.push_back(robot.id);
  return all;
}

/// Listens to `muster run`: who died, who is about to come back. Ends with the launcher.
void listen(LineChannel& control, dds::RadioLockstep& radio) {
  while (const auto line = control.read_line()) {
    const auto message = nlohmann::json::parse(*line);
    if (message.contains("dead")) radio.lost(RobotId{message["dead"].get<std::uint32_t>()});
    if (message.contains("expected")) {
      radio.expected(RobotId{message["expected"].get<std::uint32_t>()},
                     message["life"].get<dds::Life>());
    }
  }
}

volatile std::sig_atomic_t g_stop = 0;

/// Until the launcher hangs up; without one, until Ctrl-C.
int run_lab(const commsim::LabOptions& options) {
  end_with_launcher();
  log::open(options.out + "/logs", "commsim");
  LineChannel control(options.control_fd);
  const auto tell = [&](const nlohmann::json& message) {
    if (options.control_fd >= 0) control.write_line(message.dump());
  };
  commsim::LabRadio radio(options, tell);
  std::atomic<bool> left = false;
  std::jthread listener;
  if (options.control_fd >= 0) {
    listener = std::jthread([&] {
      while (control.read_line()) {
      }
      left = true;
    });
  } else {
    for (int signal : {SIGTERM, SIGINT}) std::signal(signal, [](int) { g_stop = 1; });
  }
  tell({{"started", true}});
  radio.run([&] { return left || g_stop != 0; });
  tell({{"radio", radio.finish()}});
  log::info("ended");
  return 0;
}

int run(const world::HubOptions& options) {
  end_with_launcher();
  log::open(options.out + "/logs", "commsim");
  const mission::Mission mission =
      mission::Mission::load(options.mission_file, options.set, options.faults);
  dds::RadioLockstep radio(
      dds::BarrierConfig::from(dds::vendor_from(options.vendor), options.domain),
      robots_of(mission), mission.station());
  // Loaded while everybody finds each other.
  commsim::Relay relay(mission, world::Scene::load(mission));
  relay.log_to(options.out + "/air.csv");
  relay.judge_journals_in(options.out);
  LineChannel control(options.control_fd);
  std::thread listener;
  if (options.control_fd >= 0) listener = std::thread([&] { listen(control, radio); });

  std::string error, note;
  try {
    note = radio.run(
        {.step =
             [&](const mission::Truth& truth, const auto& sent) {
               commsim::Relay::Outcome outcome = relay.step(truth, sent);
               return dds::RadioLockstep::Output{std::move(outcome.deliveries), outcome.trace};
             },
         .set_alive = [&](RobotId robot, bool alive) { relay.set_alive(robot, alive); }});
  } catch (const std::exception& e) {
    error = e.what();
  }
  relay.finish();
  if (listener.joinable()) {
    control.write_line(nlohmann::json{{"radio", relay.summary()}}.dump());
    if (!error.empty()) control.write_line(nlohmann::json{{"failed", error}}.dump());
    // The launcher hangs up when everybody has ended: until then what we sent last may still be on
    // its way.
    listener.join();
  }
  if (!error.empty()) throw Failure(error);
  log::info("ended: {}", note);
  return 0;
}

}  // namespace
}  // namespace muster

int main(int argc, char** argv) {
  return muster::run_program("muster-commsim", [&] {
    muster::commsim::LabOptions options;
    bool lab = false;
    CLI::App app{
        "muster-commsim: the radio. Hears what every robot sends, decides by range and walls who "
        "receives it, and delivers it one tick later. Started by `muster run`; robots in the field "
        "have a real radio instead, robots in a lab have this one (`muster lab`)."};
    muster::world::add_hub_options(app, options, "directory for air.csv; its logs/ gets the log");
    app.add_flag("--lab", lab,
                 "real time, and poses from a motion capture: no barrier, no world; --domain is "
                 "that of the poses");
    app.add_option("--transport-profile", options.profile,
                   "in a lab, the network of the radio: sim-localhost, wired or wifi-unicast")
        ->capture_default_str();
    app.add_option("--interface", options.network_interface, "in a lab, its network interface");
    app.add_option("--peers", options.peers, "in a lab, addresses of the robots' computers")
        ->delimiter(',');
    if (!muster::parse_command_line(app, argc, argv)) return 0;
    return lab ? muster::run_lab(options) : muster::run(options);
  });
}
