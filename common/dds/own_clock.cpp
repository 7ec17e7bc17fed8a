#include "common/dds/own_clock.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/convert.h"
#include "common/dds/retime.h"

namespace muster::dds {
namespace {

using mission::Message;
using mission::MessageClass;

/// A sender's clock that differs by more is not explained by what its beacon took.
constexpr Duration kOtherTime{1'000'000};
constexpr const char* kSkew = "skew";

/// A teammate with another idea of time still says where it is now, and what comes then.
void take_over(Message& beacon, SimTime now) try {
  const Duration off = now - decode<mission::Beacon>(beacon).mission_time;
  if (std::abs(off.us) > kOtherTime.us) retime_beacon(beacon, [&](SimTime t) { return t + off; });
} catch (const BadInput&) {
  // Refused, and said so, by the robot.
}

}  // namespace

void OwnClock::hear(const Message& message, double monotonic_s) {
  if (message.cls == MessageClass::kBeacon) {
    const auto beacon = decode<mission::Beacon>(message);
    clock_.beacon_says(beacon.stratum, beacon.mission_time.s(), monotonic_s);
  } else if (message.cls == MessageClass::kOdometry) {
    const double driver_s = decode<mission::Odometry>(message).time.s();
    if (!clock_.set()) log::info("the drivers' clock says {:.3f} s", driver_s);
    clock_.driver_says(driver_s, monotonic_s);
  }
}

void OwnClock::enter(mission::StepInput& input, double monotonic_s) const {
  input.clock_bound = Duration::from_s(clock_.bound_s(monotonic_s));
  const Duration ahead = Duration::from_s(clock_.ahead(monotonic_s));
  for (Message& sample : input.bus) {
    if (ahead.us != 0) retime_sample(sample, [&](SimTime t) { return t + ahead; });
  }
  for (Message& message : input.air) {
    if (message.cls == MessageClass::kBeacon) take_over(message, input.now);
  }
}

void OwnClock::leave(mission::StepOutput& output, double monotonic_s) const {
  for (Message& command : output.bus) {
    retime_command(command, [&](SimTime t) {
      return SimTime::from_s(clock_.driver_when(t.s(), monotonic_s));
    });
  }
  for (Message& message : output.air) {
    if (message.cls == MessageClass::kBeacon) set_stratum(message, clock_.stratum(monotonic_s));
  }
}

namespace {

/// The world's time is the monotonic clock of every robot, and its drivers'.
class Clocked final : public mission::Process {
 public:
  Clocked(std::unique_ptr<mission::Process> process, bool station,
          std::vector<mission::ScriptedEvent> skews)
      : process_(std::move(process)), own_(station), skews_(std::move(skews)) {}

  RobotId id() const override { return process_->id(); }
  void keep(std::unique_ptr<store::Journal> journal) override {
    process_->keep(std::move(journal));
  }
  mission::WholeMapBytes whole_map_bytes() override { return process_->whole_map_bytes(); }
  void finish(const std::string& dir) override { process_->finish(dir); }

  mission::StepOutput step(const mission::StepInput& given) override {
    const double world_s = given.now.s();
    own_.clock().driver_says(world_s, world_s);
    skew(given.now);
    for (const Message& message : given.air) {
      try {
        if (message.cls == MessageClass::kBeacon) own_.hear(message, world_s);
      } catch (const BadInput&) {
        // Refused, and said so, by the robot.
      }
    }
    mission::StepInput input = given;
    input.now = SimTime::from_s(own_.clock().at(world_s));
    own_.enter(input, world_s);
    mission::StepOutput output = process_->step(input);
    own_.leave(output, world_s);
    return output;
  }

 private:
  /// What its script has for it since the step before; what happened while it was dead did not
  /// happen to this clock.
  void skew(SimTime now) {
    for (const mission::ScriptedEvent& event : skews_) {
      if (event.at > now || event.at <= stepped_.value_or(now - kTick)) continue;
      log::warn("its clock is skewed by {} s", event.value);
      own_.clock().skew(event.value, now.s());
    }
    stepped_ = now;
  }

  std::unique_ptr<mission::Process> process_;
  OwnClock own_;
  std::vector<mission::ScriptedEvent> skews_;  ///< of this robot
  std::optional<SimTime> stepped_;
};

}  // namespace

std::unique_ptr<mission::Process> with_own_clock(std::unique_ptr<mission::Process> process,
                                                 const mission::Mission& mission) {
  std::vector<mission::ScriptedEvent> skews;
  std::ranges::copy_if(mission.script, std::back_inserter(skews),
                       [](const mission::ScriptedEvent& e) { return e.verb == kSkew; });
  if (skews.empty()) return process;
  const RobotId self = process->id();
  std::erase_if(skews, [&](const mission::ScriptedEvent& e) { return !e.concerns(self); });
  const bool station = mission.robot(self).role == mission::Role::kStation;
  return std::make_unique<Clocked>(std::move(process), station, std::move(skews));
}

}  // namespace muster::dds
