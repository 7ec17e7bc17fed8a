#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "common/core/error.h"
#include "common/core/program.h"
#include "deploy/muster/child.h"
#include "deploy/muster/commands.h"
#include "deploy/muster/interrupt.h"
#include "deploy/muster/pose_player.h"
#include "deploy/muster/run_options.h"
#include "deploy/muster/summary.h"

namespace muster::command {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::json;

/// The radio gets this long to write its files; then it is killed.
constexpr auto kFarewell = std::chrono::seconds(10);
/// After the last pose of a log, so that it runs out and is seen to.
constexpr auto kAfterlife = std::chrono::seconds(1);

constexpr const char* kFooter =
    R"(Real robots in a room with motion capture, real time, and a radio that is cut off by the mission's range and walls.
What to publish, and what robots need: commsim/README.md, "In a lab".

Examples
  muster lab deploy/missions/pagoda.yaml --interface wlan0 --transport-profile wifi-unicast --peers 10.42.0.2,10.42.0.3
  muster lab deploy/missions/pagoda.yaml --poses lab.csv              plays a log of poses: t_s,robot,x,y,z,yaw_rad
  muster lab deploy/missions/pagoda.yaml --poses runs/p1/tracks.csv --await 2,3   … once robots 2 and 3 have been heard

Files in --out: air.csv (see `muster air`) tracks.csv (what can be replayed) summary.json logs/)";

struct LabOptions {
  std::string mission_file, faults, dds = "cyclonedds", out, profile = "sim-localhost", interface;
  std::vector<std::string> set, peers;
  std::string poses;
  std::vector<std::uint32_t> await;
  std::uint32_t domain = 59;
  double duration_s = 0;
  bool out_is_new = false;

  void validate(const mission::Mission& mission) const {
    dds::profile_from(profile);
    if (domain > 98) throw BadInput("--domain: must be below 99 (the radio uses the next one)");
    if (duration_s < 0) throw BadInput("--duration: must be a number of seconds, 0 or more");
    if (!await.empty() && poses.empty()) throw BadInput("--await: needs a log, --poses FILE");
    for (const std::uint32_t id : await) {
      if (!mission.has(RobotId{id}))
        throw BadInput(fmt::format("--await: the mission has no robot {}", id));
    }
  }
};

/// The radio as a child, and what it says as lines for people.
class Lab {
 public:
  Lab(const LabOptions& options, std::optional<PoseLog> log)
      : options_(options), log_(std::move(log)) {
    for (const std::uint32_t id : options.await) awaited_.insert(RobotId{id});
  }

  int run() {
    setenv(kLauncherVariable, std::to_string(getpid()).c_str(), 1);
    radio_.emplace(ChildConfig{.name = "commsim",
                               .program = "muster-commsim",
                               .arguments = arguments(),
                               .log_dir = options_.out + "/logs",
                               .robot = kNoRobot,
                               .channel = true});
    while (radio_->running()) {
      wait();
      if (started_) play();
      if (interrupt_.wished()) end();
      if (ended_ && Clock::now() - *ended_ > kFarewell) radio_->signal(SIGKILL);
    }
    return conclude();
  }

 private:
  std::vector<std::string> arguments() const {
    std::vector<std::string> all{"--lab",
                                 "--mission",
                                 options_.mission_file,
                                 "--domain",
                                 std::to_string(options_.domain),
                                 "--dds",
                                 options_.dds,
                                 "--out",
                                 options_.out,
                                 "--transport-profile",
                                 options_.profile};
    for (const std::string& pair : options_.set) all.insert(all.end(), {"--set", pair});
    for (const std::string& peer : options_.peers) all.insert(all.end(), {"--peers", peer});
    if (!options_.faults.empty()) all.insert(all.end(), {"--faults", options_.faults});
    if (!options_.interface.empty()) all.insert(all.end(), {"--interface", options_.interface});
    return all;
  }

  void wait() {
    // What it said before it ended comes first.
    pollfd polls[] = {{interrupt_.wished() ? -1 : interrupt_.fd(), POLLIN, 0},
                      {hung_up_ ? radio_->pidfd() : radio_->channel()->fd(), POLLIN, 0}};
    if (poll(polls, 2, log_ ? 10 : 200) <= 0 || polls[1].revents == 0) return;
    if (hung_up_) return radio_->reap();
    for (const std::string& line : radio_->channel()->read_available(hung_up_))
      hear(json::parse(line));
  }

  void hear(const json& message) {
    if (message.contains("started")) {
      started_ = Clock::now();
      say(fmt::format("the radio is on: poses on DDS domain {}, robots on {}", options_.domain,
                      options_.domain + 1));
    } else if (message.contains("heard")) {
      awaited_.erase(RobotId{message["heard"].get<std::uint32_t>()});
      say(fmt::format("robot {} speaks", message["heard"].get<std::uint32_t>()));
    } else if (message.contains("pose")) {
      say(fmt::format("robot {} {}", message["pose"].get<std::uint32_t>(),
                      message["known"].get<bool>()
                          ? "is seen"
                          : "is not seen: it is unheard and hears nothing"));
    } else if (message.contains("radio")) {
      summary_ = message["radio"];
    }
  }

  void say(const std::string& what) {
    const double t_s = std::chrono::duration<double>(Clock::now() - *started_).count();
    fmt::print("{:7.1f} s  {}\n", t_s, what);
    std::fflush(stdout);
  }

  void play() {
    const auto now = Clock::now();
    if (options_.duration_s > 0 &&
        now - *started_ > std::chrono::duration<double>(options_.duration_s))
      return end();
    if (!log_ || !awaited_.empty()) return;
    if (!player_) {
      player_.emplace(*log_, dds::vendor_from(options_.dds), options_.domain);
      player_->start();
      say(fmt::format("the log begins: {:.1f} s", log_->end_s() - log_->begin_s()));
    }
    if (player_->play()) {
      played_ = now;
    } else if (now - played_ > kAfterlife) {
      end();
    }
  }

  void end() {
    if (ended_) return;
    ended_ = Clock::now();
    radio_->channel()->end_writing();
  }

  int conclude() {
    if (!summary_) {
      const std::string words = radio_->last_words();
      fmt::print(stderr, "{}\n",
                 words.empty() ? "muster: the radio " + radio_->how_ended() : words);
      if (!started_ && options_.out_is_new)
        remove_results(options_.out, radio_->exit_code() != kExitBadInput);
      return radio_->exit_code() == kExitBadInput ? kExitBadInput : kExitFailure;
    }
    json summary = *summary_;
    summary["dds"] = options_.dds;
    write_summary(options_.out, summary);
    say(fmt::format("over; who heard whom: muster air {}", options_.out));
    return 0;
  }

  const LabOptions& options_;
  const std::optional<PoseLog> log_;
  const Interrupt interrupt_;
  std::optional<Child> radio_;
  std::optional<PosePlayer> player_;
  std::set<RobotId> awaited_;
  bool hung_up_ = false;
  std::optional<Clock::time_point> started_, ended_;
  Clock::time_point played_;
  std::optional<json> summary_;
};

int run(LabOptions& options) {
  const mission::Mission mission =
      mission::Mission::load(options.mission_file, options.set, options.faults);
  options.validate(mission);
  std::optional<PoseLog> log;
  if (!options.poses.empty()) log = PoseLog::load(options.poses, mission);
  if (options.out.empty()) options.out = "runs/lab-" + mission.name;
  options.out_is_new = prepare_output(options.out);
  return Lab(options, std::move(log)).run();
}

}  // namespace

void add_lab_command(CLI::App& app, Action& action) {
  auto o = std::make_shared<LabOptions>();
  CLI::App* command = app.add_subcommand(
      "lab", "The radio of a lab: real robots, poses from motion capture, walls from the scene");
  command->add_option("MISSION", o->mission_file, "mission file: its scene, fleet and radio")
      ->required();
  command->add_option("--poses", o->poses,
                      "plays this log instead of a motion capture; ends with it");
  command
      ->add_option("--await", o->await, "the log begins when these robots have been heard, by id")
      ->delimiter(',');
  command
      ->add_option("--domain", o->domain,
                   "DDS domain of the poses, on this computer; robots are on the next one")
      ->capture_default_str();
  command->add_option("--dds", o->dds, "who carries the messages")
      ->check(CLI::IsMember({"cyclonedds", "fastdds"}))
      ->capture_default_str();
  command
      ->add_option(
          "--transport-profile", o->profile,
          "the network to the robots: sim-localhost (this computer), wired or wifi-unicast")
      ->capture_default_str();
  command->add_option("--interface", o->interface, "network interface to the robots");
  command->add_option("--peers", o->peers, "addresses of the robots' computers")->delimiter(',');
  command
      ->add_option("--set", o->set,
                   "KEY=VALUE: overrides a key of the mission file (radio.range_m=8); repeatable")
      ->expected(1)
      ->take_all();
  command->add_option("--faults", o->faults, "file with a script: jam, cut, loss, mute-beacons");
  command->add_option("--out", o->out, "directory for the results (default: runs/lab-<mission>)");
  command->add_option("--duration", o->duration_s, "stop after so many seconds (default: Ctrl-C)");
  command->footer(kFooter);
  command->callback([o, &action] { action = [o] { return run(*o); }; });
}

}  // namespace muster::command
