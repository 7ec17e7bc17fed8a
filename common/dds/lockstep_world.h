#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/dds/barrier.h"
#include "common/dds/inbox.h"

namespace muster::dds {

/// The master of the barrier. Per tick k:
///
///     begin(k, samples, truth) → (robots step) → await_robots() → [world moves on, samples of k+1
///     …] → await_radio() → k+1
///
/// A robot whose process is gone (`lost`) is waited for no longer and its endpoints are deleted.
class WorldLockstep {
 public:
  WorldLockstep(const BarrierConfig& config, const std::vector<RobotId>& fleet, RobotId station);
  /// Everyone still waiting is told that the run has failed, unless `end` was called.
  ~WorldLockstep();

  /// Returns when every process is matched with every other on both domains; names who is missing
  /// otherwise.
  void await_everyone();

  /// Bus samples of a tick, as soon as they are known; `announce` says how many they were.
  void write_samples(RobotId robot, const std::vector<mission::Message>& samples);
  void write_truth(mission::Truth truth);
  /// Tick k: everyone may go, but who is `paused`: it is not waited for, and what is on its way to
  /// it waits for it.
  void announce(std::uint64_t k, const std::set<RobotId>& paused = {});

  struct Answers {
    std::map<RobotId, mission::Done> robots;
    std::vector<mission::Message> commands;  ///< in (src, n) order
  };
  Answers await_robots();
  /// The radio's answer; then what it delivered to the station, in (src, n) order, is there for
  /// `station_heard`.
  mission::Done await_radio();
  std::vector<mission::Message> station_heard();

  /// Ends the run in order.
  void end(const std::string& note);

  /// From any thread: the robot's process is gone.
  void notify_lost(RobotId robot);
  /// Robots whose process went away since the last call.
  std::vector<RobotId> take_lost();
  /// Waits until `robot`'s process is gone (scripted kill: the launcher was asked).
  void await_lost(RobotId robot);
  /// A robot comes back: opens the ways to its next life, which is then to be started.
  Life expect(RobotId robot);
  /// Returns true when it is matched everywhere, false when its process is gone again.
  bool await_back(RobotId robot);
  /// From any thread: whoever waits here throws WorldEnded (an operator's Ctrl-C; a radio that
  /// died).
  void interrupt(const std::string& note, bool failed);

  const std::set<RobotId>& alive() const { return alive_; }

 private:
  void open_way(RobotId robot, Life life);
  void listen_to_station(Life life);
  void take(Inbox::Clock::time_point deadline);
  void drop(RobotId robot);
  /// Waits until `complete()`; throws Failure with `missing()` when nothing new came for too long.
  template <class Complete, class Missing>
  void await(std::chrono::duration<double> patience, const Complete& complete,
             const Missing& missing);
  bool matched() const;
  bool is_ready(RobotId robot) const;
  bool is_radio_ready() const;
  void write_tick();
  void keep_saying();

  BarrierConfig config_;
  RobotId station_;
  Inbox inbox_;
  std::unique_ptr<Participant> bus_, air_;
  std::unique_ptr<Writer> tick_writer_, truth_writer_;
  ReaderSet done_, commands_, ear_;
  std::map<RobotId, WriterSet> samples_;
  Undertaker undertaker_;

  std::set<RobotId> alive_, paused_;
  Lives lives_;        ///< the present or last one of everybody
  Lives ready_;        ///< that said that they are matched
  Lives radio_ready_;  ///< to which the radio said to have a way
  std::uint64_t busy_heard_ = 0;
  mission::Tick tick_;
  std::map<RobotId, std::uint32_t> bus_counts_;  ///< of the samples written for the next tick
  std::map<RobotId, std::uint32_t> air_counts_;  ///< of the deliveries for the next tick
  std::map<RobotId, mission::Done> dones_;
  std::optional<mission::Done> radio_done_;
  std::map<RobotId, std::vector<mission::Message>> commands_in_;
  std::vector<mission::Message> ear_in_;
  std::vector<RobotId> lost_;  ///< not yet taken by the caller

  std::mutex notices_mutex_;
  std::vector<RobotId> notices_;
  std::optional<WorldEnded> interrupted_;

  std::mutex tick_mutex_;
  mission::Message tick_message_;
  std::condition_variable ending_changed_;
  bool ending_ = false;
  std::thread keeper_;
};

}  // namespace muster::dds
