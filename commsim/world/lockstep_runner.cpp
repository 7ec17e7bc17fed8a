#include "commsim/world/lockstep_runner.h"

#include <algorithm>
#include <chrono>
#include <future>
#include <map>
#include <memory>
#include <optional>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/lockstep_world.h"
#include "commsim/world/flight.h"
#include "commsim/world/pacer.h"
#include "commsim/world/world.h"

namespace muster::world {
namespace {

/// How often a world that waits for its site looks whether it shall stop.
constexpr auto kLook = std::chrono::milliseconds(50);

struct Loaded {
  Loaded(const mission::Mission& mission, const RunnerOptions& options)
      : world(mission, Scene::load(mission)),
        flight(mission, world,
               {.out = options.out, .duration_s = options.duration_s, .trace = options.trace}) {}
  World world;
  Flight flight;
};

class LockstepRunner {
 public:
  explicit LockstepRunner(const RunnerOptions& options)
      : options_(options),
        control_(options.control_fd),
        mission_(mission::Mission::load(options.mission_file, options.set, options.faults)),
        barrier_(dds::BarrierConfig::from(dds::vendor_from(options.vendor), options.domain),
                 robots(), mission_.station()) {
    control_.on_dead([this](RobotId robot) { barrier_.notify_lost(robot); });
    world_ = std::async(std::launch::async, [this] { return load_world(); });
  }
  ~LockstepRunner() {
    control_.on_dead({});
    control_.on_stop({});
  }

  int run() {
    // Until the clock runs nothing looks at stop_reason(), so Ctrl-C has to reach into the waiting.
    control_.on_stop([this](const std::string& reason) { barrier_.interrupt(reason, false); });
    begin();
    control_.on_stop({});
    try {
      const std::string reason = fly();
      barrier_.end(reason);
      control_.tell({{"summary", flight().finish(reason)}});
    } catch (const std::exception& e) {
      log::error("{}", e.what());
      nlohmann::json summary = flight().finish(e.what());
      summary["failed"] = true;
      control_.tell({{"summary", std::move(summary)}});
      control_.tell({{"failed", e.what()}});
      throw;
    }
    control_.await_hang_up();
    return 0;
  }

 private:
  std::vector<RobotId> robots() const {
    std::vector<RobotId> all;
    for (const mission::RobotConfig& robot : mission_.fleet) all.push_back(robot.id);
    return all;
  }

  /// On a thread of its own, while processes find each other.
  std::unique_ptr<Loaded> load_world() {
    const auto begin = std::chrono::steady_clock::now();
    try {
      auto loaded = std::make_unique<Loaded>(mission_, options_);
      load_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      return loaded;
    } catch (const std::exception& e) {
      // Told before the robots are, so that the run ends with this and not with what they make of
      // it.
      control_.tell(
          {{"failed", e.what()}, {"bad_input", dynamic_cast<const BadInput*>(&e) != nullptr}});
      barrier_.interrupt("the site cannot be used", true);
      throw;
    }
  }

  /// Until everyone is matched and the site is there.
  void begin() {
    try {
      barrier_.await_everyone();
      control_.tell({{"matched", true}});
      while (world_.wait_for(kLook) != std::future_status::ready) {
        if (const std::string reason = control_.stop_reason(); !reason.empty())
          throw dds::WorldEnded(reason, false);
      }
    } catch (const dds::WorldEnded& stopped) {
      if (stopped.failed()) world_.get();  // throws what was wrong with the site
      control_.tell({{"failed", std::string(stopped.what()) + " before the mission began"}});
      throw;
    }
    loaded_ = world_.get();
    control_.tell({{"started", true}, {"load_s", load_s_}});
  }

  World& world() { return loaded_->world; }
  Flight& flight() { return loaded_->flight; }

  /// Returns why the flight is over.
  std::string fly() {
    const Pacer pacer(options_.speed);
    std::optional<mission::Done> radio;  // of the tick before, once it is here
    for (std::uint64_t k = 0;; ++k) {
      log::set_time(time_of_tick(k));
      if (k > 0 && (has_script(k) || is_somebody_due(k))) radio = radio_answers();
      run_script(k);
      restart_due(k);
      const mission::Truth truth = write_measurements(k);
      // The radio decides on tick k−1 while the world measures tick k.
      if (k > 0 && !radio) radio = radio_answers();
      radio.reset();
      flight().tick_begins(k, truth);
      flight().station_heard(barrier_.station_heard());
      barrier_.announce(k, world().paused(k));

      dds::WorldLockstep::Answers answers = barrier_.await_robots();
      note_lost();
      for (auto& [robot, done] : answers.robots) report(robot, done);
      if (k % 10 == 0) control_.tell({{"progress", flight().progress()}});
      world().end_tick(k, answers.commands);
      for (const auto& [verb, robot] : control_.take_requests()) flight().request(verb, robot);
      if (auto reason = flight().end_reason(k, barrier_.alive().size() + back_.size())) {
        radio_answers();
        return *std::move(reason);
      }
      if (std::string reason = control_.stop_reason(); !reason.empty()) {
        radio_answers();
        return reason;
      }
      pacer.wait_until(time_of_tick(k + 1));
    }
  }

  mission::Done radio_answers() {
    mission::Done done = barrier_.await_radio();
    flight().radio_done(done.trace);
    return done;
  }

  bool has_script(std::uint64_t k) {
    for (const mission::ScriptedEvent& event : world().scripted(k)) {
      if (event.verb == "kill" || event.verb == "revive") return true;
    }
    return false;
  }

  /// Kills and revivals between ticks: the clock stands until they are done.
  void run_script(std::uint64_t k) {
    for (const mission::ScriptedEvent& event : world().scripted(k)) {
      const bool lives = barrier_.alive().contains(event.robot);
      if (event.verb == "kill" && lives) {
        control_.tell({{"kill", event.robot.value}});
        barrier_.await_lost(event.robot);
        note_lost(event.robot);
      } else if (event.verb == "revive" && !lives) {
        revive(event.robot, event.journal_lost);
      }
    }
  }

  /// The clock stands until it is matched everywhere, or has died on the way.
  void revive(RobotId robot, bool journal_lost) {
    note_lost();  // before the tick began, or it would count as lost after it has come back
    const dds::Life life = barrier_.expect(robot);
    control_.tell({{"revive", robot.value}, {"life", life}, {"journal_lost", journal_lost}});
    back_.erase(robot);
    if (!barrier_.await_back(robot)) return;
    flight().robot_back(robot);
    world().set_alive(robot, true);
  }

  bool is_somebody_due(std::uint64_t k) const {
    return std::ranges::any_of(back_, [&](const auto& b) { return b.second <= time_of_tick(k); });
  }

  /// Of those whose process ended without the script.
  void restart_due(std::uint64_t k) {
    const std::map<RobotId, SimTime> back = back_;
    for (const auto& [robot, at] : back) {
      if (at <= time_of_tick(k) && !barrier_.alive().contains(robot)) revive(robot, false);
    }
  }

  mission::Truth write_measurements(std::uint64_t k) {
    for (const World::Samples& samples : world().begin_tick(k))
      barrier_.write_samples(samples.robot, samples.messages);
    mission::Truth truth = world().truth();
    truth.k = k;
    truth.time = time_of_tick(k);
    barrier_.write_truth(truth);
    return truth;
  }

  void note_lost(RobotId by_script = kNoRobot) {
    for (RobotId robot : barrier_.take_lost()) {
      const bool scripted = robot == by_script;
      flight().robot_lost(robot, scripted ? "scripted" : control_.how_lost(robot));
      world().set_alive(robot, false);
      if (options_.restart_s > 0 && !scripted)
        back_[robot] = flight().now() + Duration::from_s(options_.restart_s);
    }
  }

  void report(RobotId robot, mission::Done& done) {
    flight().robot_done({.robot = robot,
                         .trace = done.trace,
                         .declares_complete = done.declares_complete,
                         .activity = done.activity,
                         .planning = std::move(done.planning)});
  }

  const RunnerOptions options_;
  RunControl control_;
  const mission::Mission mission_;
  dds::WorldLockstep barrier_;
  double load_s_ = 0;
  std::map<RobotId, SimTime> back_;  // when who died by itself is to be started again
  std::future<std::unique_ptr<Loaded>> world_;
  std::unique_ptr<Loaded> loaded_;
};

}  // namespace

int run_in_lockstep(const RunnerOptions& options) { return LockstepRunner(options).run(); }

}  // namespace muster::world
