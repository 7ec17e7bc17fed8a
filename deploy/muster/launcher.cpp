#include "deploy/muster/launcher.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

#include "common/core/cpu_time.h"
#include "common/core/error.h"
#include "common/core/program.h"
#include "common/dds/barrier.h"
#include "common/store/journal.h"
#include "commsim/world/flight.h"
#include "deploy/muster/capture.h"
#include "deploy/muster/child.h"
#include "deploy/muster/control_socket.h"
#include "deploy/muster/interrupt.h"
#include "deploy/muster/progress.h"
#include "deploy/muster/run_results.h"
#include "deploy/muster/summary.h"

namespace muster::command {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::json;

/// After the end everybody gets this long to write files and leave; then they are killed.
constexpr auto kFarewell = std::chrono::seconds(20);
/// After Ctrl-C the world gets this long to come to the end of its tick.
constexpr auto kPatience = std::chrono::seconds(10);
/// After a failure robots get this long to write what they have.
constexpr auto kLastWords = std::chrono::milliseconds(3500);
constexpr auto kMeasureEvery = std::chrono::seconds(1);

/// One run with all its processes.
class Launcher {
 public:
  Launcher(const mission::Mission& mission, const RunOptions& options)
      : mission_(mission),
        options_(options),
        domain_(options.domain.value()),
        progress_(Progress::form_for(options.json)),
        socket_(options.out, [this](auto verb, RobotId robot) { return request(verb, robot); }) {}

  int run() {
    start_all();
    while (!everybody_left()) {
      wait();
      if (interrupt_.wished()) stop("interrupted");
      enforce_deadlines();
    }
    return conclude();
  }

 private:
  bool direct() const { return options_.link == "direct"; }

  // ---- starting

  void start_all() {
    start_capture();
    setenv(kLauncherVariable, std::to_string(getpid()).c_str(), 1);
    start_hub("world", world_arguments());
    if (!direct()) start_hub("commsim", common_arguments(hub_vendor()));
    for (const mission::RobotConfig& robot : mission_.fleet) {
      if (std::count(options_.external.begin(), options_.external.end(), robot.id.value)) {
        progress_.note(
            fmt::format("start robot {} yourself:  {}", robot.id.value, command_line(robot.id)));
      } else {
        start_robot(robot.id, dds::kFirstLife);
      }
    }
    started_ = Clock::now();
  }

  void start_capture() {
    if (!options_.capture) return;
    try {
      capture_.emplace(options_.out + "/air.pcapng", domain_);
    } catch (const Failure&) {
      if (options_.out_is_new) remove_results(options_.out, false);
      throw;
    }
  }

  void start_hub(const std::string& name, std::vector<std::string> arguments) {
    children_.push_back(std::make_unique<Child>(ChildConfig{.name = name,
                                                            .program = "muster-" + name,
                                                            .arguments = std::move(arguments),
                                                            .log_dir = options_.out + "/logs",
                                                            .robot = kNoRobot,
                                                            .channel = true}));
  }

  void start_robot(RobotId id, dds::Life life) {
    const bool station = mission_.robot(id).role == mission::Role::kStation;
    children_.push_back(std::make_unique<Child>(
        ChildConfig{.name = fmt::format("{}-{}", station ? "gcs" : "agent", id.value),
                    .program = station ? "muster-gcs" : "muster-agent",
                    .arguments = robot_arguments(id, life),
                    .log_dir = options_.out + "/logs",
                    .robot = id,
                    .again = life > dds::kFirstLife,
                    .channel = false}));
  }

  std::string hub_vendor() const { return options_.dds == "mixed" ? "cyclonedds" : options_.dds; }

  std::string vendor_of(RobotId id) const {
    if (options_.dds != "mixed") return options_.dds;
    const auto robot = std::find_if(mission_.fleet.begin(), mission_.fleet.end(),
                                    [&](const auto& r) { return r.id == id; });
    return (robot - mission_.fleet.begin()) % 2 ? "fastdds" : "cyclonedds";
  }

  std::vector<std::string> common_arguments(const std::string& vendor) const {
    std::vector<std::string> all = {
        "--mission", options_.mission_file, "--domain", std::to_string(domain_), "--dds", vendor,
        "--out",     options_.out};
    for (const std::string& pair : options_.overrides()) all.insert(all.end(), {"--set", pair});
    if (!options_.faults.empty()) all.insert(all.end(), {"--faults", options_.faults});
    return all;
  }

  std::vector<std::string> world_arguments() const {
    std::vector<std::string> all = common_arguments(hub_vendor());
    all.insert(all.end(), {"--duration", fmt::format("{}", options_.duration_s), "--speed",
                           fmt::format("{}", options_.speed_factor())});
    if (direct()) all.push_back("--direct");
    if (options_.trace) all.push_back("--trace");
    if (options_.restart_s > 0)
      all.insert(all.end(), {"--restart", fmt::format("{}", options_.restart_s)});
    return all;
  }

  std::vector<std::string> robot_arguments(RobotId id, dds::Life life) const {
    std::vector<std::string> all = common_arguments(vendor_of(id));
    all.insert(all.end(), {"--id", std::to_string(id.value)});
    if (!direct()) all.insert(all.end(), {"--epoch", std::to_string(life)});
    if (direct())
      all.insert(all.end(), {"--field", "--speed", fmt::format("{}", options_.speed_factor())});
    return all;
  }

  std::string command_line(RobotId id) const {
    const bool station = mission_.robot(id).role == mission::Role::kStation;
    std::string line = program_directory() + (station ? "/muster-gcs" : "/muster-agent");
    for (const std::string& argument : robot_arguments(id, dds::kFirstLife))
      line += " '" + argument + "'";
    return line;
  }

  // ---- watching

  void wait() {
    std::vector<pollfd> polls{{interrupt_.wished() ? -1 : interrupt_.fd(), POLLIN, 0}};
    std::vector<Child*> who{nullptr};
    std::vector<bool> is_channel{false};
    const auto watch = [&](int fd, Child* child, bool channel) {
      polls.push_back({fd, POLLIN, 0});
      who.push_back(child);
      is_channel.push_back(channel);
    };
    for (const auto& child : children_) {
      // What it said before it ended comes first.
      if (child->channel() && !hung_up_.contains(child.get())) {
        watch(child->channel()->fd(), child.get(), true);
      } else if (child->running()) {
        watch(child->pidfd(), child.get(), false);
      }
    }
    if (poll(polls.data(), polls.size(), 200) <= 0) return;
    for (std::size_t i = 1; i < polls.size(); ++i) {
      if (polls[i].revents == 0) continue;
      if (is_channel[i]) {
        bool closed = false;
        for (const std::string& line : who[i]->channel()->read_available(closed))
          hear(json::parse(line));
        if (closed) hung_up_.insert(who[i]);
      } else {
        who[i]->reap();
        ended(*who[i]);
      }
    }
  }

  void hear(const json& message) {
    if (message.contains("progress")) {
      last_progress_ = message["progress"];
      progress_.show(last_progress_);
      measure_memory();
    }
    if (message.contains("matched")) {
      matched_s_ = std::chrono::duration<double>(Clock::now() - started_).count();
    }
    if (message.contains("started")) {
      begun_ = true;
      load_s_ = message.value("load_s", 0.0);
      started_ = Clock::now();
      progress_.restart_clock();
      cpu_before_s_ = cpu_s();
    }
    if (message.contains("kill")) kill_robot(RobotId{message["kill"].get<std::uint32_t>()});
    if (message.contains("revive")) {
      revive_robot(RobotId{message["revive"].get<std::uint32_t>()},
                   message["life"].get<dds::Life>(), message.value("journal_lost", false));
    }
    if (message.contains("radio")) radio_summary_ = message["radio"];
    if (message.contains("failed")) {
      fail(message["failed"].get<std::string>(),
           message.value("bad_input", false) ? kExitBadInput : kExitFailure);
    }
    if (message.contains("summary")) {
      summary_ = message["summary"];
      wall_s_ = std::chrono::duration<double>(Clock::now() - started_).count();
      measure_memory(true);
      begin_farewell();
    }
  }

  void ended(Child& child) {
    if (leaving_) return;
    if (child.robot() == kNoRobot) {
      const std::string words = child.last_words();
      fail(words.empty() ? fmt::format("the {} was lost ({}): the run is over", child.name(),
                                       child.how_ended())
                         : words,
           child.exit_code());
    } else if (!begun_ && child.exit_code() != 0) {
      const std::string words = child.last_words();
      fail(words.empty() ? fmt::format("{} {}", child.name(), child.how_ended()) : words,
           child.exit_code());
    } else {
      const bool scripted = scripted_kills_.erase(child.robot()) > 0;
      const std::string how = scripted ? "scripted" : child.how_ended();
      if (!scripted)
        progress_.note(fmt::format("robot {} is lost: its process {}", child.robot().value, how));
      tell("commsim", {{"dead", child.robot().value}});
      tell("world", {{"dead", child.robot().value}, {"how", how}});
    }
  }

  void kill_robot(RobotId id) {
    for (const auto& child : children_) {
      if (child->robot() != id || !child->running()) continue;
      scripted_kills_.insert(id);
      child->signal(SIGKILL);
    }
  }

  void revive_robot(RobotId id, dds::Life life, bool journal_lost) {
    if (journal_lost) store::Journal::lose(store::Journal::path(options_.out, id));
    tell("commsim", {{"expected", id.value}, {"life", life}});
    start_robot(id, life);
  }

  void tell(const std::string& name, const json& message) {
    for (const auto& child : children_) {
      if (child->name() == name && child->channel()) child->channel()->write_line(message.dump());
    }
  }

  std::string request(mission::RequestVerb verb, RobotId robot) {
    if (robot != kNoRobot && !mission_.has(robot))
      return fmt::format("the mission has no robot {}", robot.value);
    if (!begun_) return "the mission has not started yet";
    json message = {{"request", world::to_string(verb)}};
    if (robot != kNoRobot) message["robot"] = robot.value;
    tell("world", message);
    return "ok";
  }

  void measure_memory(bool now = false) {
    if (!now && Clock::now() - measured_ < kMeasureEvery) return;
    measured_ = Clock::now();
    for (const auto& child : children_) child->measure_memory();
  }

  // ---- ending

  void stop(const std::string& reason) {
    if (leaving_ || stopping_) return;
    stopping_ = true;
    deadline_ = Clock::now() + kPatience;
    tell("world", {{"stop", reason}});
    stop_reason_ = reason;
  }

  /// The run has failed; whoever still runs is told to end (robots write what they have), and
  /// killed.
  void fail(const std::string& why, int status = kExitFailure) {
    if (failure_) return;
    failure_ = why;
    failure_status_ = status == kExitBadInput ? kExitBadInput : kExitFailure;
    leaving_ = true;
    for (const auto& child : children_) child->signal(SIGTERM);
    deadline_ = Clock::now() + kLastWords;
  }

  void begin_farewell() {
    if (leaving_) return;
    leaving_ = true;
    deadline_ = Clock::now() + kFarewell;
    if (!direct()) return;
    for (const auto& child : children_) {
      if (child->robot() != kNoRobot) child->signal(SIGTERM);
    }
  }

  void enforce_deadlines() {
    if (leaving_ && robots_left()) {
      for (const auto& child : children_) {
        if (child->channel()) child->channel()->end_writing();
      }
    }
    if (!deadline_ || Clock::now() < *deadline_) return;
    if (stopping_ && !leaving_) {
      fail(stop_reason_ + ", and the world did not come to an end");
    } else {
      for (const auto& child : children_) child->signal(SIGKILL);
    }
  }

  bool robots_left() const {
    return std::none_of(children_.begin(), children_.end(),
                        [](const auto& c) { return c->robot() != kNoRobot && c->running(); });
  }

  bool everybody_left() const {
    return leaving_ && std::none_of(children_.begin(), children_.end(),
                                    [](const auto& c) { return c->running(); });
  }

  double cpu_s() const {
    double all = cpu_of_process_s();
    for (const auto& child : children_) all += child->cpu_s();
    return all;
  }

  void stop_capture() {
    if (!capture_) return;
    const Capture::Outcome outcome = capture_->stop();
    if (outcome.missed == 0) return;
    progress_.note(fmt::format("air.pcapng: {} packets came too fast to be kept, {} are there",
                               outcome.missed, outcome.packets));
  }

  Cost cost() const {
    Cost cost{.wall_s = wall_s_,
              .cpu_s = cpu_s() - cpu_before_s_,
              .agent_rss_mb = {},
              .station_rss_mb = {}};
    for (const auto& child : children_) {
      if (child->robot() == kNoRobot || child->peak_rss_mb() <= 0) continue;
      auto& peak = mission_.robot(child->robot()).role == mission::Role::kStation
                       ? cost.station_rss_mb
                       : cost.agent_rss_mb;
      peak = std::max(peak.value_or(0), child->peak_rss_mb());
    }
    return cost;
  }

  int conclude() {
    if (failure_ && !begun_) {
      fmt::print(stderr, "{}\n",
                 failure_->rfind("muster", 0) == 0 ? *failure_ : "muster: " + *failure_);
      if (options_.out_is_new) remove_results(options_.out, failure_status_ != kExitBadInput);
      return failure_status_;
    }
    json summary = summary_ ? *summary_ : last_progress_;
    summary.update(radio_summary_);
    stop_capture();
    if (failure_) {
      summary["failed"] = true;
      summary["complete"] = false;
      summary["ended"] = *failure_;
      summary["mission"] = mission_.name;
      summary["strategy"] = mission_.strategy;
      summary["seed"] = mission_.seed;
      if (!summary.contains("simulated_s")) summary["simulated_s"] = summary.value("t_s", 0.0);
      if (!summary_) summary["t_s"] = nullptr;
    }
    if (wall_s_ <= 0) wall_s_ = std::chrono::duration<double>(Clock::now() - started_).count();
    summary["dds"] = options_.dds;
    summary["transport"] = direct() ? "direct" : "dds";
    summary["matched_s"] = matched_s_;
    summary["load_s"] = load_s_;
    add_cost(summary, cost(), mission_.fleet.size());
    finish_results(options_, summary);
    progress_.result(summary, options_.out);
    if (failure_) fmt::print(stderr, "muster: {}\n", *failure_);
    return exit_status(summary);
  }

  const mission::Mission& mission_;
  const RunOptions& options_;
  const Interrupt interrupt_;
  const std::uint32_t domain_;
  Progress progress_;
  std::optional<Capture> capture_;
  std::vector<std::unique_ptr<Child>> children_;
  std::set<const Child*> hung_up_;
  std::set<RobotId> scripted_kills_;
  std::atomic<bool> begun_ = false;  ///< the clock runs
  bool stopping_ = false, leaving_ = false;
  std::string stop_reason_;
  std::optional<std::string> failure_;
  int failure_status_ = kExitFailure;
  std::optional<Clock::time_point> deadline_;
  Clock::time_point started_ = Clock::now(), measured_;
  double wall_s_ = 0, matched_s_ = 0, load_s_ = 0, cpu_before_s_ = 0;
  std::optional<json> summary_;
  json radio_summary_ = json::object(), last_progress_ = json::object();
  ControlSocket socket_;  // last: its thread asks the members above
};

}  // namespace

int run_over_dds(const mission::Mission& mission, const RunOptions& options) {
  return Launcher(mission, options).run();
}

}  // namespace muster::command
