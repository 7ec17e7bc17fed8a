#include "common/dds/lockstep_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/core/log.h"
#include "common/dds/convert.h"
#include "common/dds/order.h"

namespace muster::dds {

using mission::Message;
using mission::MessageClass;
using Clock = Inbox::Clock;

namespace {

constexpr auto kKeepSaying = std::chrono::seconds(1);
/// Who is silent for so long in the middle of a tick is named in the log: even one that works long
/// says so every second.
constexpr auto kOdd = std::chrono::seconds(3);

template <class Ids>
std::string list(const Ids& ids) {
  std::string all;
  for (RobotId id : ids) all += (all.empty() ? "" : ", ") + std::to_string(id.value);
  return all;
}

}  // namespace

WorldLockstep::WorldLockstep(const BarrierConfig& config, const std::vector<RobotId>& fleet,
                             RobotId station)
    : config_(config),
      station_(station),
      bus_(make_participant(participant_config(config, config.domain, 0))),
      air_(make_participant(participant_config(config, config.domain + 1, kWorldOnAir))) {
  const OnMessage on_message = inbox_.on_message();
  const OnMatch on_match = inbox_.on_match();
  tick_writer_ = bus_->writer(MessageClass::kTick, kSimPartition, Delivery::kLatest, on_match);
  truth_writer_ = bus_->writer(MessageClass::kTruth, kSimPartition, Delivery::kEvery, on_match);
  done_.add(*bus_, MessageClass::kDone, kSimPartition, on_message, on_match);
  commands_ = ReaderSet(*bus_, kCommandClasses, "bus.*", on_message, on_match);
  listen_to_station(kFirstLife);
  for (RobotId robot : fleet) {
    open_way(robot, kFirstLife);
    alive_.insert(robot);
  }
}

WorldLockstep::~WorldLockstep() {
  if (!ending_) {
    tick_.phase = mission::TickPhase::kFailed;
    tick_.note = "the run has failed";
    try {
      write_tick();
    } catch (const std::exception& e) {
      log::warn("nobody could be told that the run has failed: {}", e.what());
    }
  }
  {
    const std::lock_guard lock(tick_mutex_);
    ending_ = true;
  }
  ending_changed_.notify_one();
  if (keeper_.joinable()) keeper_.join();
}

void WorldLockstep::open_way(RobotId robot, Life life) {
  const std::string partition = bus_partition(robot, life);
  WriterSet ways(*bus_, kSampleClasses, partition, inbox_.on_match());
  if (robot == station_)
    ways.add(*bus_, MessageClass::kOperatorRequest, partition, inbox_.on_match());
  samples_[robot] = std::move(ways);
  lives_[robot] = life;
}

void WorldLockstep::listen_to_station(Life life) {
  ear_ = ReaderSet(*air_, mission::kAirClasses, down_partition(station_, life), inbox_.on_message(),
                   inbox_.on_match());
}

bool WorldLockstep::is_ready(RobotId robot) const { return said_of(ready_, robot, lives_); }

bool WorldLockstep::is_radio_ready() const {
  return std::ranges::all_of(alive_,
                             [&](RobotId robot) { return said_of(radio_ready_, robot, lives_); });
}

bool WorldLockstep::matched() const {
  const int robots = static_cast<int>(samples_.size());
  const bool ways = std::all_of(samples_.begin(), samples_.end(),
                                [](const auto& way) { return way.second.matched(1); });
  return ways && tick_writer_->matched() >= robots + 1 && truth_writer_->matched() >= 1 &&
         done_.matched(robots + 1) && commands_.matched(robots) &&
         (!alive_.contains(station_) || ear_.matched(1));
}

void WorldLockstep::take(Clock::time_point deadline) {
  std::vector<Message> messages = inbox_.take(deadline);
  std::vector<RobotId> notices;
  {
    const std::lock_guard lock(notices_mutex_);
    if (interrupted_) throw *interrupted_;
    notices = std::exchange(notices_, {});
  }
  for (Message& message : messages) {
    if (message.cls == MessageClass::kDone) {
      auto done = decode<mission::Done>(message);
      const bool radio = done.process == kRadioId;
      if (done.k == kReady) {
        for (const auto& [robot, life] : lives_in(done))
          (radio ? radio_ready_ : ready_)[robot] = life;
      } else if (done.k == kBusy) {
        ++busy_heard_;
      } else if (done.k != tick_.k) {
        continue;  // an answer that was said again
      } else if (radio) {
        radio_done_ = std::move(done);
      } else {
        dones_[done.process] = std::move(done);
      }
    } else if (mission::is_air(message.cls)) {
      ear_in_.push_back(std::move(message));
    } else {
      commands_in_[peek_envelope(message.cdr).src].push_back(std::move(message));
    }
  }
  for (RobotId robot : notices) drop(robot);
}

void WorldLockstep::drop(RobotId robot) {
  if (alive_.erase(robot) == 0) return;
  undertaker_.bury(std::move(samples_.at(robot)));
  samples_.erase(robot);
  bus_counts_.erase(robot);
  air_counts_.erase(robot);
  dones_.erase(robot);
  commands_in_.erase(robot);
  if (robot == station_) ear_in_.clear();
  lost_.push_back(robot);
}

template <class Complete, class Missing>
void WorldLockstep::await(std::chrono::duration<double> patience, const Complete& complete,
                          const Missing& missing) {
  const auto last = in(std::max(patience, config_.busy));
  auto deadline = in(patience), odd = in(kOdd);
  while (!complete()) {
    const auto seen = [&] {
      return dones_.size() + commands_in_.size() + ear_in_.size() + ready_.size() + busy_heard_;
    };
    const auto before = seen();
    take(std::min(deadline, odd));
    if (seen() != before) {
      deadline = std::min(in(patience), last);
      odd = in(kOdd);
    }
    const auto now = Clock::now();
    if (now >= deadline) {
      throw Failure(fmt::format("nothing new for {:.0f} s: {}", patience.count(), missing()));
    }
    if (now >= odd && patience <= config_.missing) log::warn("still waiting: {}", missing());
    if (now >= odd) odd = deadline;
  }
}

void WorldLockstep::await_everyone() {
  const auto silent = [&] {
    std::vector<RobotId> all;
    std::ranges::copy_if(alive_, std::back_inserter(all), [&](RobotId r) { return !is_ready(r); });
    return all;
  };
  await(
      config_.start, [&] { return silent().empty() && is_radio_ready() && matched(); },
      [&] {
        std::string who = silent().empty() ? "" : "not matched: robots " + list(silent());
        if (!is_radio_ready()) who += who.empty() ? "the radio is not matched" : "; the radio";
        return who.empty() ? "the world's own endpoints are not all matched" : who;
      });
  keeper_ = std::thread([this] { keep_saying(); });
}

void WorldLockstep::write_samples(RobotId robot, const std::vector<Message>& samples) {
  const auto way = samples_.find(robot);
  if (way == samples_.end()) return;
  for (const Message& sample : samples) way->second.write(sample);
  bus_counts_[robot] = static_cast<std::uint32_t>(samples.size());
}

void WorldLockstep::write_truth(mission::Truth truth) {
  truth.envelope = {.n = truth.k, .src = kWorldId, .cls = MessageClass::kTruth, .sent = truth.time};
  truth_writer_->write(encode(truth).cdr);
}

void WorldLockstep::write_tick() {
  tick_.envelope = {.n = tick_.k, .src = kWorldId, .cls = MessageClass::kTick, .sent = tick_.time};
  const std::lock_guard lock(tick_mutex_);
  tick_message_ = encode(tick_);
  tick_writer_->write(tick_message_.cdr);
}

/// Says the last tick again every second: who hears nothing for longer knows that the world is
/// gone.
void WorldLockstep::keep_saying() {
  std::unique_lock lock(tick_mutex_);
  while (!ending_changed_.wait_for(lock, kKeepSaying, [this] { return ending_; })) {
    if (!tick_message_.cdr.empty()) tick_writer_->write(tick_message_.cdr);
  }
}

void WorldLockstep::announce(std::uint64_t k, const std::set<RobotId>& paused) {
  paused_ = paused;
  tick_.k = k;
  tick_.time = time_of_tick(k);
  tick_.phase = mission::TickPhase::kRun;
  tick_.alive.clear();
  tick_.expect.clear();
  for (RobotId robot : alive_) {
    if (paused_.contains(robot)) continue;
    tick_.alive.push_back(robot);
    tick_.expect.push_back(
        {.process = robot, .bus = bus_counts_[robot], .air = air_counts_[robot]});
    bus_counts_.erase(robot);
    air_counts_.erase(robot);
  }
  // Answers to the tick before may have been said again since they were taken.
  dones_.clear();
  radio_done_.reset();
  write_tick();
}

WorldLockstep::Answers WorldLockstep::await_robots() {
  const auto has = [&](RobotId robot) {
    if (paused_.contains(robot)) return true;
    const auto done = dones_.find(robot);
    if (done == dones_.end()) return false;
    const auto commands = commands_in_.find(robot);
    return (commands == commands_in_.end() ? 0 : commands->second.size()) >= done->second.sent_bus;
  };
  await(
      config_.missing, [&] { return std::all_of(alive_.begin(), alive_.end(), has); },
      [&] {
        std::string missing;
        for (const RobotId robot : alive_) {
          if (has(robot)) continue;
          const auto done = dones_.find(robot);
          const std::string how =
              done == dones_.end() ? std::to_string(robot.value)
                                   : fmt::format("{} ({} of {} commands came)", robot.value,
                                                 commands_in_[robot].size(), done->second.sent_bus);
          missing += (missing.empty() ? "" : ", ") + how;
        }
        return fmt::format("tick {}: no answer from robots {}", tick_.k, missing);
      });
  Answers answers{.robots = std::exchange(dones_, {}), .commands = {}};
  for (auto& [robot, messages] : commands_in_)
    std::move(messages.begin(), messages.end(), std::back_inserter(answers.commands));
  commands_in_.clear();
  sort_messages(answers.commands);
  return answers;
}

mission::Done WorldLockstep::await_radio() {
  const auto heard = [&]() -> std::size_t {
    if (!alive_.contains(station_)) return 0;
    for (const mission::Expect& e : radio_done_->deliveries) {
      if (e.process == station_) return e.air;
    }
    return 0;
  };
  await(
      config_.missing, [&] { return radio_done_ && ear_in_.size() >= heard(); },
      [&] {
        return radio_done_
                   ? fmt::format("tick {}: the world overheard {} of {} messages to the station",
                                 tick_.k, ear_in_.size(), heard())
                   : fmt::format("tick {}: no answer from the radio", tick_.k);
      });
  for (const mission::Expect& e : radio_done_->deliveries) {
    if (alive_.contains(e.process)) air_counts_[e.process] += e.air;
  }
  return *std::exchange(radio_done_, std::nullopt);
}

std::vector<Message> WorldLockstep::station_heard() {
  sort_messages(ear_in_);
  return std::exchange(ear_in_, {});
}

void WorldLockstep::end(const std::string& note) {
  tick_.phase = mission::TickPhase::kEnd;
  tick_.note = note;
  tick_.alive.assign(alive_.begin(), alive_.end());
  tick_.expect.clear();
  write_tick();
  const std::lock_guard lock(tick_mutex_);
  ending_ = true;
}

void WorldLockstep::notify_lost(RobotId robot) {
  {
    const std::lock_guard lock(notices_mutex_);
    notices_.push_back(robot);
  }
  inbox_.wake();
}

void WorldLockstep::interrupt(const std::string& note, bool failed) {
  {
    const std::lock_guard lock(notices_mutex_);
    interrupted_.emplace(note, failed);
  }
  inbox_.wake();
}

std::vector<RobotId> WorldLockstep::take_lost() { return std::exchange(lost_, {}); }

void WorldLockstep::await_lost(RobotId robot) {
  await(
      config_.missing, [&] { return !alive_.contains(robot); },
      [&] { return fmt::format("robot {} was to be killed and still lives", robot.value); });
}

Life WorldLockstep::expect(RobotId robot) {
  const Life life = lives_.at(robot) + 1;
  open_way(robot, life);
  if (robot == station_) listen_to_station(life);
  alive_.insert(robot);
  return life;
}

bool WorldLockstep::await_back(RobotId robot) {
  const auto back = [&] { return is_ready(robot) && is_radio_ready() && matched(); };
  await(
      config_.start, [&] { return !alive_.contains(robot) || back(); },
      [&] { return fmt::format("robot {} was started again and is not matched", robot.value); });
  return alive_.contains(robot);
}

}  // namespace muster::dds
