#include "common/dds/field.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/core/log.h"
#include "common/dds/convert.h"
#include "common/dds/network.h"
#include "common/dds/order.h"

namespace muster::dds {
namespace {

using mission::Message;
using mission::MessageClass;
using Clock = Inbox::Clock;

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
  if (!config.network_interface.empty()) await_carrier(config.network_interface);
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

Link link_from(const std::string& name) {
  if (name == "direct") return Link::kDirect;
  if (name == "radio") return Link::kRadio;
  throw BadInput("link '" + name + "' is not one of direct, radio");
}

FieldRunner::FieldRunner(const FieldConfig& config)
    : config_(config),
      bus_(make_participant(bus_config(config))),
      air_(make_participant(air_config(config))),
      own_(config.station, config.speed) {
  const OnMessage on_message = inbox_.on_message();
  samples_ = ReaderSet(*bus_, kSampleClasses, bus_partition(config.self), on_message, {});
  if (config.station)
    samples_.add(*bus_, MessageClass::kOperatorRequest, bus_partition(config.self), on_message, {});
  commands_ = WriterSet(*bus_, kCommandClasses, bus_partition(config.self), {});
  const bool direct = config.link == Link::kDirect;
  const std::string hears = direct ? kAirPartition : down_partition(config.self);
  const std::string says = direct ? kAirPartition : up_partition(config.self);
  for (MessageClass cls : mission::kAirClasses) {
    air_in_reader_.add(*air_, cls, hears, on_message, {}, Delivery::kBestEffort);
    air_out_.add(*air_, cls, says, {}, Delivery::kBestEffort);
  }
}

FieldRunner::~FieldRunner() = default;

double FieldRunner::now_s() const { return own_.clock().at(monotonic_s()); }

void FieldRunner::sort_in(std::vector<Message>&& messages) {
  for (Message& message : messages) {
    try {
      if (peek_envelope(message.cdr).src == config_.self) continue;
      own_.hear(message, monotonic_s());
    } catch (const std::exception& e) {
      log::warn("refused a message: {}", e.what());
      continue;
    }
    (mission::is_air(message.cls) ? air_in_ : bus_in_).push_back(std::move(message));
  }
}

void FieldRunner::run(const Step& step, const volatile std::sig_atomic_t& stop) {
  while (!own_.clock().set() && !stop)
    sort_in(inbox_.take(Clock::now() + std::chrono::milliseconds(200)));
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
    own_.enter(input, monotonic_s());
    mission::StepOutput output = step(input);
    own_.leave(output, monotonic_s());
    for (const Message& message : output.air) air_out_.write(message);
    for (const Message& message : output.bus) commands_.write(message);
  }
}

}  // namespace muster::dds
