#include "commsim/world/lockstep_runner.h"

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

class LockstepRunner {
 public:
  explicit LockstepRunner(const RunnerOptions& options)
      : options_(options),
        control_(options.control_fd),
        mission_(mission::Mission::load(options.mission_file, options.set)),
        barrier_(dds::BarrierConfig::from(dds::vendor_from(options.vendor), options.domain),
                 robots(), mission_.station()),
        world_(mission_, Scene::load(mission_)),
        flight_(mission_, world_, {.out = options.out, .duration_s = options.duration_s}) {
    control_.on_dead([this](RobotId robot) { barrier_.notify_lost(robot); });
  }
  ~LockstepRunner() {
    control_.on_dead({});
    control_.on_stop({});
  }

  int run() {
    // Until the clock runs nothing looks at stop_reason(), so Ctrl-C has to reach into the waiting.
    control_.on_stop([this](const std::string& reason) { barrier_.interrupt(reason, false); });
    try {
      barrier_.await_everyone();
      control_.on_stop({});
      control_.tell({{"matched", true}});
      const std::string reason = fly();
      barrier_.end(reason);
      control_.tell({{"summary", flight_.finish(reason)}});
    } catch (const dds::WorldEnded& stopped) {
      barrier_.end(stopped.what());
      control_.tell({{"summary", flight_.finish(stopped.what())}});
    } catch (const std::exception& e) {
      log::error("{}", e.what());
      nlohmann::json summary = flight_.finish(e.what());
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

  /// Returns why the flight is over.
  std::string fly() {
    const Pacer pacer(options_.speed);
    std::optional<mission::Done> radio;  // of the tick before, once it is here
    for (std::uint64_t k = 0;; ++k) {
      log::set_time(time_of_tick(k));
      if (k > 0 && has_script(k)) radio = radio_answers();
      run_script(k);
      const mission::Truth truth = write_measurements(k);
      // The radio decides on tick k−1 while the world measures tick k.
      if (k > 0 && !radio) radio = radio_answers();
      radio.reset();
      flight_.tick_begins(k, truth);
      flight_.station_heard(barrier_.station_heard());
      barrier_.announce(k);

      dds::WorldLockstep::Answers answers = barrier_.await_robots();
      note_lost();
      for (auto& [robot, done] : answers.robots) report(robot, done);
      if (k % 10 == 0) control_.tell({{"progress", flight_.progress()}});
      world_.end_tick(k, answers.commands);
      for (const auto& [verb, robot] : control_.take_requests()) flight_.request(verb, robot);
      if (const auto reason = flight_.end_reason(k, barrier_.alive().size())) {
        radio_answers();
        return *reason;
      }
      if (const std::string reason = control_.stop_reason(); !reason.empty()) {
        radio_answers();
        return reason;
      }
      pacer.wait_until(time_of_tick(k + 1));
    }
  }

  mission::Done radio_answers() {
    const mission::Done done = barrier_.await_radio();
    flight_.radio_done(done.trace);
    return done;
  }

  bool has_script(std::uint64_t k) const {
    for (const mission::ScriptedEvent& event : world_.scripted(k)) {
      if (event.verb == "kill" || event.verb == "revive") return true;
    }
    return false;
  }

  /// Kills and revivals between ticks: the clock stands until they are done.
  void run_script(std::uint64_t k) {
    for (const mission::ScriptedEvent& event : world_.scripted(k)) {
      const bool lives = barrier_.alive().contains(event.robot);
      if (event.verb == "kill" && lives) {
        control_.tell({{"kill", event.robot.value}});
        barrier_.await_lost(event.robot);
        barrier_.take_lost();
        flight_.robot_lost(event.robot, "scripted");
        world_.set_alive(event.robot, false);
      } else if (event.verb == "revive" && !lives) {
        barrier_.expect(event.robot);
        control_.tell({{"revive", event.robot.value}});
        barrier_.await_back(event.robot);
        flight_.robot_back(event.robot);
        world_.set_alive(event.robot, true);
      }
    }
  }

  mission::Truth write_measurements(std::uint64_t k) {
    for (const World::Samples& samples : world_.begin_tick(k))
      barrier_.write_samples(samples.robot, samples.messages);
    mission::Truth truth = world_.truth();
    truth.k = k;
    truth.time = time_of_tick(k);
    barrier_.write_truth(truth);
    return truth;
  }

  void note_lost() {
    for (RobotId robot : barrier_.take_lost()) {
      flight_.robot_lost(robot, control_.how_lost(robot));
      world_.set_alive(robot, false);
    }
  }

  void report(RobotId robot, mission::Done& done) {
    flight_.robot_done({.robot = robot,
                        .trace = done.trace,
                        .declares_complete = done.declares_complete,
                        .activity = done.activity,
                        .planning = std::move(done.planning)});
  }

  const RunnerOptions options_;
  RunControl control_;
  const mission::Mission mission_;
  dds::WorldLockstep barrier_;  // before the world: processes find each other while it loads
  World world_;
  Flight flight_;
};

}  // namespace

int run_in_lockstep(const RunnerOptions& options) { return LockstepRunner(options).run(); }

}  // namespace muster::world
