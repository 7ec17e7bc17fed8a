#include <fmt/format.h>

#include <algorithm>
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

constexpr auto kSayAgain = std::chrono::milliseconds(100);

}  // namespace

RadioLockstep::RadioLockstep(const BarrierConfig& config, const std::vector<RobotId>& fleet,
                             RobotId station)
    : config_(config),
      station_(station),
      bus_(make_participant(participant_config(config, config.domain, kRadioOnBus))),
      air_(make_participant(participant_config(config, config.domain + 1, 0))) {
  const OnMessage on_message = inbox_.on_message();
  const OnMatch on_match = inbox_.on_match();
  sim_.add(*bus_, MessageClass::kTick, kSimPartition, on_message, on_match);
  sim_.add(*bus_, MessageClass::kTruth, kSimPartition, on_message, on_match);
  done_bus_.add(*bus_, MessageClass::kDone, kSimPartition, on_match);
  up_ = ReaderSet(*air_, mission::kAirClasses, "up.*", on_message, on_match);
  done_air_.add(*air_, MessageClass::kDone, kSimPartition, on_message, on_match);
  for (RobotId robot : fleet) {
    open_way(robot, kFirstLife);
    alive_[robot] = true;
  }
}

RadioLockstep::~RadioLockstep() = default;

void RadioLockstep::open_way(RobotId robot, Life life) {
  down_[robot] =
      WriterSet(*air_, mission::kAirClasses, down_partition(robot, life), inbox_.on_match());
  lives_[robot] = life;
  must_rematch_ = true;
}

bool RadioLockstep::matched() const {
  // A killed process stays matched for a while, so counts alone would not show that its successor
  // is there: it has to have spoken.
  const bool spoken = std::all_of(lives_.begin(), lives_.end(), [&](const auto& entry) {
    return said_of(ready_, entry.first, lives_);
  });
  // The world overhears what the station is sent.
  const bool ways = std::all_of(down_.begin(), down_.end(), [&](const auto& way) {
    return way.second.matched(way.first == station_ ? 2 : 1);
  });
  const int robots = static_cast<int>(down_.size());
  return spoken && ways && up_.matched(robots) && done_air_.matched(robots) && sim_.matched(1) &&
         done_bus_.matched(1);
}

void RadioLockstep::lost(RobotId robot) {
  {
    const std::lock_guard lock(notices_mutex_);
    notices_.emplace_back(robot, std::nullopt);
  }
  inbox_.wake();
}

void RadioLockstep::expected(RobotId robot, Life life) {
  {
    const std::lock_guard lock(notices_mutex_);
    notices_.emplace_back(robot, life);
  }
  inbox_.wake();
}

void RadioLockstep::apply_notices() {
  decltype(notices_) notices;
  {
    const std::lock_guard lock(notices_mutex_);
    notices = std::exchange(notices_, {});
  }
  for (const auto& [robot, life] : notices) {
    if (life) {
      open_way(robot, *life);
    } else {
      const auto way = down_.find(robot);
      if (way == down_.end()) continue;
      undertaker_.bury(std::move(way->second));  // what is owed to it must not hold anybody up
      down_.erase(way);
      lives_.erase(robot);
    }
  }
}

void RadioLockstep::take(Clock::time_point deadline) {
  std::vector<Message> messages = inbox_.take(deadline);
  apply_notices();
  for (Message& message : messages) {
    if (message.cls == MessageClass::kTick) {
      world_heard_ = Clock::now();
      auto tick = decode<mission::Tick>(message);
      if (tick.phase == mission::TickPhase::kFailed) throw WorldEnded(tick.note, true);
      // Said again: nothing must hang on one message.
      if (started_ && tick.k == tick_.k && answer_.k == tick.k) say_done(answer_);
      if (!started_ || tick.k > tick_.k || tick.phase == mission::TickPhase::kEnd) {
        tick_ = std::move(tick);
        tick_is_new_ = true;
      }
    } else if (message.cls == MessageClass::kTruth) {
      auto truth = decode<mission::Truth>(message);
      truths_[truth.k] = std::move(truth);
    } else if (message.cls == MessageClass::kDone) {
      auto done = decode<mission::Done>(message);
      if (done.k == kReady) {
        for (const auto& [robot, life] : lives_in(done)) ready_[robot] = life;
      } else {
        answers_[done.process] = std::move(done);
      }
    } else {
      sent_[peek_envelope(message.cdr).src].push_back(std::move(message));
    }
  }
}

void RadioLockstep::say_done(mission::Done done) {
  done.process = kRadioId;
  done.envelope = {.n = done.k, .src = kRadioId, .cls = MessageClass::kDone, .sent = tick_.time};
  done.cpu_ms = static_cast<float>(1e3 * cpu_of_process_s());
  done_bus_.write(encode(done));
}

/// Before the first tick and whenever a robot has come back: says that everyone is matched until
/// the clock goes on.
void RadioLockstep::await_matches() {
  const auto deadline = in(config_.start);
  while (!tick_is_new_) {
    const bool all = matched();
    if (all && must_rematch_) {
      say_done(ready(lives_));
      if (started_) must_rematch_ = false;
    }
    const auto patience =
        !started_ || must_rematch_
            ? Clock::now() + kSayAgain
            : world_heard_ + std::chrono::duration_cast<Clock::duration>(config_.silence);
    take(std::min(deadline, patience));
    if (started_ && Clock::now() - world_heard_ >= config_.silence) {
      throw Failure(fmt::format("the world has been silent for {:.0f} s: it is gone, or stopped",
                                config_.silence.count()));
    }
    if (!started_ && Clock::now() >= deadline) {
      throw Failure(all ? "the world did not start the clock"
                        : fmt::format("not everyone was matched on DDS domain {} within {:.0f} s",
                                      config_.domain + 1, config_.start.count()));
    }
  }
  tick_is_new_ = false;
  started_ = true;
  must_rematch_ = false;
}

bool RadioLockstep::has_everything() {
  if (!truths_.contains(tick_.k)) return false;
  return std::all_of(tick_.alive.begin(), tick_.alive.end(), [&](RobotId robot) {
    if (!down_.contains(robot)) return true;
    const auto answer = answers_.find(robot);
    return answer != answers_.end() && answer->second.k == tick_.k &&
           sent_[robot].size() >= answer->second.sent_air;
  });
}

void RadioLockstep::await_sent() {
  while (!has_everything() && !tick_is_new_) {
    // The world watches over missing answers; here only its silence matters.
    take(world_heard_ + std::chrono::duration_cast<Clock::duration>(config_.silence));
    if (Clock::now() - world_heard_ >= config_.silence) {
      throw Failure(fmt::format("the world has been silent for {:.0f} s: it is gone, or stopped",
                                config_.silence.count()));
    }
  }
}

std::string RadioLockstep::run(const Callbacks& callbacks) {
  while (true) {
    await_matches();
    if (tick_.phase != mission::TickPhase::kRun) return tick_.note;
    log::set_time(tick_.time);
    for (auto& [robot, lives] : alive_) {
      const bool now =
          std::find(tick_.alive.begin(), tick_.alive.end(), robot) != tick_.alive.end();
      if (now != lives) callbacks.set_alive(robot, lives = now);
    }
    await_sent();
    if (tick_is_new_) continue;  // the world gave up on this tick

    for (auto& [robot, messages] : sent_) sort_messages(messages);
    std::erase_if(sent_, [](const auto& entry) { return entry.second.empty(); });
    const Output output = callbacks.step(truths_.at(tick_.k), sent_);
    sent_.clear();
    truths_.erase(truths_.begin(), truths_.upper_bound(tick_.k));

    mission::Done done;
    done.k = tick_.k;
    done.trace = output.trace;
    for (const auto& [robot, messages] : output.deliveries) {
      const auto way = down_.find(robot);
      if (way == down_.end() || messages.empty()) continue;
      for (const Message& message : messages) way->second.write(message);
      done.deliveries.push_back(
          {.process = robot, .bus = 0, .air = static_cast<std::uint32_t>(messages.size())});
    }
    answer_ = std::move(done);
    say_done(answer_);
  }
}

}  // namespace muster::dds
