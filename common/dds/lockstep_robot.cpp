#include <fmt/format.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "common/core/cpu_time.h"
#include "common/core/log.h"
#include "common/dds/convert.h"
#include "common/dds/lockstep.h"
#include "common/dds/order.h"

namespace muster::dds {

using mission::Message;
using mission::MessageClass;
using Clock = Inbox::Clock;

namespace {

constexpr auto kSayBusy = std::chrono::seconds(1);
/// All that is announced is on its way already; what takes so long is worth a line in the log.
constexpr auto kOdd = std::chrono::seconds(3);
/// How often a robot that waits looks whether it was asked to stop.
constexpr auto kLookForStop = std::chrono::milliseconds(200);
/// Until the first tick, readiness is said again this often: the first time may fall before the
/// world knows us.
constexpr auto kSayAgain = std::chrono::milliseconds(100);

}  // namespace

RobotLockstep::RobotLockstep(const BarrierConfig& config, RobotId self, bool station, Life life)
    : config_(config),
      self_(self),
      life_(life),
      bus_(make_participant(participant_config(config, config.domain, participant_on_bus(self)))),
      air_(make_participant(
          participant_config(config, config.domain + 1, participant_on_air(self)))) {
  const OnMessage on_message = inbox_.on_message();
  const OnMatch on_match = inbox_.on_match();
  const std::string on_bus = bus_partition(self, life);
  samples_ = ReaderSet(*bus_, kSampleClasses, on_bus, on_message, on_match);
  if (station) samples_.add(*bus_, MessageClass::kOperatorRequest, on_bus, on_message, on_match);
  tick_reader_.add(*bus_, MessageClass::kTick, kSimPartition, on_message, on_match);
  commands_ = WriterSet(*bus_, kCommandClasses, bus_partition(self), on_match);
  // What says that we are ready comes last on each domain: who hears it knows the writers before
  // it, which the hub cannot count, because those of our former lives still do.
  done_bus_.add(*bus_, MessageClass::kDone, kSimPartition, on_match);
  down_ = ReaderSet(*air_, mission::kAirClasses, down_partition(self, life), on_message, on_match);
  up_ = WriterSet(*air_, mission::kAirClasses, up_partition(self), on_match);
  done_air_.add(*air_, MessageClass::kDone, kSimPartition, on_match);
}

RobotLockstep::~RobotLockstep() = default;

bool RobotLockstep::matched() const {
  return samples_.matched(1) && tick_reader_.matched(1) && down_.matched(1) &&
         commands_.matched(1) && up_.matched(1) && done_bus_.matched(1) && done_air_.matched(1);
}

void RobotLockstep::sort_in(std::vector<Message>&& messages) {
  for (Message& message : messages) {
    if (message.cls == MessageClass::kTick) {
      world_heard_ = Clock::now();
      auto tick = decode<mission::Tick>(message);
      const bool mine = std::find(tick.alive.begin(), tick.alive.end(), self_) != tick.alive.end();
      if (tick.phase == mission::TickPhase::kFailed) throw WorldEnded(tick.note, true);
      // A tick is said again every second, so that silence means that the world is gone. Who has
      // answered it answers again: nothing must hang on one message.
      if (started_ && tick.k == tick_.k && answer_.k == tick.k) say_done(answer_);
      if ((!started_ || tick.k > tick_.k || tick.phase == mission::TickPhase::kEnd) && mine) {
        tick_ = std::move(tick);
        tick_is_new_ = true;
      }
    } else if (mission::is_air(message.cls)) {
      air_in_.push_back(std::move(message));
    } else {
      bus_in_.push_back(std::move(message));
    }
  }
}

void RobotLockstep::say_done(mission::Done done) {
  done.process = self_;
  done.envelope = {.n = done.k, .src = self_, .cls = MessageClass::kDone, .sent = tick_.time};
  const Message message = encode(done);
  done_bus_.write(message);
  done_air_.write(message);
}

void RobotLockstep::await_first_tick(const volatile std::sig_atomic_t& stop) {
  const auto deadline = in(config_.start);
  while (!tick_is_new_ && !stop) {
    if (matched()) say_done(ready({{self_, life_}}));
    sort_in(inbox_.take(std::min(deadline, Clock::now() + kSayAgain)));
    if (Clock::now() >= deadline) {
      throw Failure(matched() ? "the world did not start the clock"
                              : fmt::format("nobody answers on DDS domains {} and {}",
                                            config_.domain, config_.domain + 1));
    }
  }
  started_ = true;
}

/// False: the run is over.
bool RobotLockstep::await_tick(const volatile std::sig_atomic_t& stop) {
  while (!tick_is_new_) {
    if (stop) {
      log::warn("asked to stop after tick {}, which is answered", tick_.k);
      return false;
    }
    sort_in(inbox_.take(Clock::now() + kLookForStop));
    if (!tick_is_new_ && Clock::now() - world_heard_ >= config_.silence) {
      throw Failure(fmt::format("the world has been silent for {:.0f} s: it is gone, or stopped",
                                config_.silence.count()));
    }
  }
  tick_is_new_ = false;
  return tick_.phase == mission::TickPhase::kRun;
}

void RobotLockstep::await_inputs(const volatile std::sig_atomic_t& stop) {
  const auto mine = std::find_if(tick_.expect.begin(), tick_.expect.end(),
                                 [&](const auto& e) { return e.process == self_; });
  const std::size_t bus = mine == tick_.expect.end() ? 0 : mine->bus;
  const std::size_t air = mine == tick_.expect.end() ? 0 : mine->air;
  const auto lacks = [&] {
    return fmt::format("tick {}: robot {} has {} of {} bus samples and {} of {} radio messages",
                       tick_.k, self_.value, bus_in_.size(), bus, air_in_.size(), air);
  };
  auto deadline = in(config_.missing), odd = in(kOdd);
  while ((bus_in_.size() < bus || air_in_.size() < air) && !stop) {
    auto messages = inbox_.take(std::min(deadline, Clock::now() + kLookForStop));
    if (!messages.empty()) {
      const bool only_ticks = std::all_of(messages.begin(), messages.end(), [](const Message& m) {
        return m.cls == MessageClass::kTick;
      });
      if (!only_ticks) deadline = in(config_.missing);
      sort_in(std::move(messages));
    }
    if (Clock::now() >= deadline) throw Failure(lacks());
    if (Clock::now() >= odd) {
      log::warn("still waiting: {}", lacks());
      odd = deadline;
    }
  }
}

void RobotLockstep::send(mission::StepOutput&& output) {
  for (const Message& message : output.air) up_.write(message);
  for (const Message& message : output.bus) commands_.write(message);
  mission::Done done;
  done.k = tick_.k;
  done.sent_air = static_cast<std::uint32_t>(output.air.size());
  done.sent_bus = static_cast<std::uint32_t>(output.bus.size());
  done.trace = output.trace;
  done.declares_complete = output.declares_complete;
  done.activity = output.activity;
  done.cpu_ms = static_cast<float>(1e3 * cpu_of_process_s());
  done.planning = std::move(output.planning);
  answer_ = std::move(done);
  say_done(answer_);
}

/// While one step takes long, the world hears so every second.
void RobotLockstep::say_busy(const std::stop_token& stop) {
  mission::Done busy;
  busy.k = kBusy;
  std::unique_lock lock(working_mutex_);
  while (!stop.stop_requested()) {
    const std::uint64_t step = working_;
    working_changed_.wait_for(lock, stop, kSayBusy, [&] { return false; });
    if (working_ != step || working_ % 2 == 0) continue;
    busy.process = self_;
    busy.envelope = {.n = busy.k, .src = self_, .cls = MessageClass::kDone, .sent = SimTime{}};
    done_bus_.write(encode(busy));
  }
}

std::string RobotLockstep::run(const Step& step, const volatile std::sig_atomic_t& stop) {
  await_first_tick(stop);
  const std::jthread keeper([this](const std::stop_token& end) { say_busy(end); });
  const auto count = [this] {
    const std::lock_guard lock(working_mutex_);
    ++working_;
  };
  while (await_tick(stop)) {
    log::set_time(tick_.time);
    await_inputs(stop);
    if (stop) {
      log::warn("asked to stop in tick {} with {} bus samples and {} radio messages", tick_.k,
                bus_in_.size(), air_in_.size());
      break;
    }
    mission::StepInput input{.tick = tick_.k,
                             .now = tick_.time,
                             .bus = std::exchange(bus_in_, {}),
                             .air = std::exchange(air_in_, {})};
    sort_messages(input.bus);
    sort_messages(input.air);
    count();
    mission::StepOutput output = step(input);
    count();
    working_changed_.notify_one();
    send(std::move(output));
  }
  return stop ? "asked to stop" : tick_.note;
}

}  // namespace muster::dds
