#include "common/dds/field.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/core/log.h"
#include "common/dds/convert.h"
#include "common/dds/order.h"

namespace muster::dds {
namespace {

using mission::Message;
using mission::MessageClass;
using Clock = Inbox::Clock;

/// The largest correction per odometry sample (10 Hz): 1 % of real time.
constexpr double kSlew_s = 0.001;

double monotonic_s() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

ParticipantConfig bus_config(const FieldConfig& config) {
  ParticipantConfig bus;
  bus.vendor = config.vendor;
  bus.profile = Profile::kSimLocalhost;
  bus.domain = config.bus_domain;
  bus.participant = participant_on_bus(config.self);
  return bus;
}

ParticipantConfig air_config(const FieldConfig& config) {
  ParticipantConfig air;
  air.vendor = config.vendor;
  air.profile = config.air_profile;
  air.domain = config.air_domain;
  air.participant = participant_on_air(config.self);
  air.star = false;
  air.network_interface = config.network_interface;
  air.peers = config.peers;
  return air;
}

}  // namespace

FieldRunner::FieldRunner(const FieldConfig& config)
    : config_(config),
      bus_(make_participant(bus_config(config))),
      air_(make_participant(air_config(config))) {
  const OnMessage on_message = inbox_.on_message();
  samples_ = ReaderSet(*bus_, kSampleClasses, bus_partition(config.self), on_message, {});
  if (config.station)
    samples_.add(*bus_, MessageClass::kOperatorRequest, bus_partition(config.self), on_message, {});
  commands_ = WriterSet(*bus_, kCommandClasses, bus_partition(config.self), {});
  for (MessageClass cls : mission::kAirClasses) {
    air_in_reader_.add(*air_, cls, kAirPartition, on_message, {}, Delivery::kBestEffort);
    air_out_.add(*air_, cls, kAirPartition, {}, Delivery::kBestEffort);
  }
}

FieldRunner::~FieldRunner() = default;

double FieldRunner::now_s() const { return *offset_s_ + config_.speed * monotonic_s(); }

void FieldRunner::correct_clock(SimTime driver_time) {
  const double measured_s = driver_time.s() - config_.speed * monotonic_s();
  if (!offset_s_) {
    offset_s_ = measured_s;
    log::info("the drivers' clock says {:.3f} s", driver_time.s());
    return;
  }
  *offset_s_ +=
      std::clamp(measured_s - *offset_s_, -kSlew_s * config_.speed, kSlew_s * config_.speed);
}

void FieldRunner::sort_in(std::vector<Message>&& messages) {
  for (Message& message : messages) {
    try {
      if (message.cls == MessageClass::kOdometry)
        correct_clock(decode<mission::Odometry>(message).time);
      if (peek_envelope(message.cdr).src == config_.self) continue;
    } catch (const std::exception& e) {
      log::warn("refused a message: {}", e.what());
      continue;
    }
    (mission::is_air(message.cls) ? air_in_ : bus_in_).push_back(std::move(message));
  }
}

void FieldRunner::run(const Step& step, const volatile std::sig_atomic_t& stop) {
  while (!offset_s_ && !stop) sort_in(inbox_.take(Clock::now() + std::chrono::milliseconds(200)));
  std::uint64_t k = 0;
  while (!stop) {
    const auto next_k =
        std::max(k + 1, static_cast<std::uint64_t>(std::max(0.0, now_s() / kTick.s())));
    const double wait_s = (static_cast<double>(next_k) * kTick.s() - now_s()) / config_.speed;
    const auto due = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>(wait_s));
    while (Clock::now() < due) sort_in(inbox_.take(due));
    k = next_k;
    log::set_time(time_of_tick(k));
    mission::StepInput input{.tick = k,
                             .now = time_of_tick(k),
                             .bus = std::exchange(bus_in_, {}),
                             .air = std::exchange(air_in_, {})};
    sort_messages(input.bus);
    sort_messages(input.air);
    const mission::StepOutput output = step(input);
    for (const Message& message : output.air) air_out_.write(message);
    for (const Message& message : output.bus) commands_.write(message);
  }
}

}  // namespace muster::dds
