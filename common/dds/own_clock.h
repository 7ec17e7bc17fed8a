#pragma once

#include <memory>
#include <vector>

#include "common/dds/mission_clock.h"
#include "common/mission/mission.h"
#include "common/mission/process.h"

namespace muster::dds {

/// What a robot does with its own clock, by whichever shell it is run: it tells the clock what it
/// hears, and translates between its own time and the drivers'.
///
///     drivers ─ their time ─▶ samples ─▶ robot, mission time ─▶ commands ─ their time ─▶ drivers
///     beacons ─ their senders' times ──▶   │  ▲
///                                          ▼  └── MissionClock: now, stratum, bound
///                                     beacons
class OwnClock {
 public:
  explicit OwnClock(bool station, double speed = 1) : clock_(station, speed) {}

  MissionClock& clock() { return clock_; }
  const MissionClock& clock() const { return clock_; }
  /// Sets the clock by a driver's or teammate's word. Throws BadInput when it is not one.
  void hear(const mission::Message& message, double monotonic_s);
  /// Before the robot's step at `input.now`: what reached it, in mission time, and the clock's
  /// bound.
  void enter(mission::StepInput& input, double monotonic_s) const;
  /// After it: commands in the drivers' time, beacons with the clock's stratum.
  void leave(mission::StepOutput& output, double monotonic_s) const;

 private:
  MissionClock clock_;
};

/// `process` with a clock of its own in a simulation where time is known to everybody, when the
/// mission's script skews a clock; else `process` itself. The world's time is then the drivers'.
std::unique_ptr<mission::Process> with_own_clock(std::unique_ptr<mission::Process> process,
                                                 const mission::Mission& mission);

}  // namespace muster::dds
