#pragma once

#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/barrier.h"
#include "common/dds/inbox.h"
#include "common/mission/process.h"

namespace muster::dds {

/// A robot's side of the barrier: waits for the tick and for exactly what it announces, in (src, n)
/// order steps the robot, sends what it says, and answers `Done`. Nothing acts on arrival.
class RobotLockstep {
 public:
  using Step = std::function<mission::StepOutput(const mission::StepInput&)>;

  RobotLockstep(const BarrierConfig& config, RobotId self, bool station, Life life = kFirstLife);
  ~RobotLockstep();

  /// Steps until the world ends the run; returns its reason. Throws WorldEnded when the run has
  /// failed, Failure when the world falls silent.
  /// `stop` may be set from a signal handler; it is looked at a few times a second.
  std::string run(const Step& step, const volatile std::sig_atomic_t& stop);

 private:
  void await_first_tick(const volatile std::sig_atomic_t& stop);
  bool await_tick(const volatile std::sig_atomic_t& stop);
  void await_inputs(const volatile std::sig_atomic_t& stop);
  void sort_in(std::vector<mission::Message>&& messages);
  void send(mission::StepOutput&& output);
  void say_done(mission::Done done);
  void say_busy(const std::stop_token& stop);
  bool matched() const;

  BarrierConfig config_;
  RobotId self_;
  Life life_;
  Inbox inbox_;
  std::unique_ptr<Participant> bus_, air_;
  ReaderSet samples_, down_, tick_reader_;
  WriterSet commands_, up_, done_bus_, done_air_;

  mission::Tick tick_;
  mission::Done answer_ = ready();  ///< to the last tick that was answered
  bool started_ = false, tick_is_new_ = false;
  Inbox::Clock::time_point world_heard_;
  std::vector<mission::Message> bus_in_, air_in_;

  std::mutex working_mutex_;
  std::condition_variable_any working_changed_;
  std::uint64_t working_ = 0;  ///< odd while a step is under way
};

/// The radio's side: hears truth, everyone's `Done` and as many messages as they announce; writes
/// deliveries and answers with their counts.
class RadioLockstep {
 public:
  struct Output {
    std::map<RobotId, std::vector<mission::Message>> deliveries;
    std::uint64_t trace = 0;
  };
  struct Callbacks {
    std::function<Output(const mission::Truth&,
                         const std::map<RobotId, std::vector<mission::Message>>&)>
        step;
    std::function<void(RobotId, bool alive)> set_alive;
  };

  RadioLockstep(const BarrierConfig& config, const std::vector<RobotId>& fleet, RobotId station);
  ~RadioLockstep();

  std::string run(const Callbacks& callbacks);
  /// From any thread: its process is gone, wait for it no longer.
  void lost(RobotId robot);
  /// From any thread: its process is about to start again; the way to that life is opened.
  void expected(RobotId robot, Life life);

 private:
  void take(Inbox::Clock::time_point deadline);
  void apply_notices();
  void open_way(RobotId robot, Life life);
  void await_matches();
  void await_sent();
  bool has_everything();
  bool matched() const;
  void say_done(mission::Done done);

  BarrierConfig config_;
  RobotId station_;
  Inbox inbox_;
  std::unique_ptr<Participant> bus_, air_;
  ReaderSet sim_, up_, done_air_;
  WriterSet done_bus_;
  std::map<RobotId, WriterSet> down_;
  Undertaker undertaker_;

  std::mutex notices_mutex_;
  std::vector<std::pair<RobotId, std::optional<Life>>> notices_;  ///< nothing: it has died
  std::map<RobotId, bool> alive_;                                 ///< as told to the callbacks
  Lives lives_;                                                   ///< to which there is a way
  Lives ready_;                                                   ///< that said so
  bool must_rematch_ = true;

  mission::Tick tick_;
  mission::Done answer_ = ready();  ///< to the last tick that was answered
  bool started_ = false, tick_is_new_ = false;
  Inbox::Clock::time_point world_heard_;
  std::map<std::uint64_t, mission::Truth> truths_;
  std::map<RobotId, mission::Done> answers_;  ///< of the robots, each the last one heard
  std::map<RobotId, std::vector<mission::Message>> sent_;
};

}  // namespace muster::dds
