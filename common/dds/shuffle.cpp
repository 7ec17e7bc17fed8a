#include "common/dds/shuffle.h"

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "common/core/random.h"

namespace muster::dds {
namespace {

using Clock = std::chrono::steady_clock;

/// Where a reader's messages go; closed when the reader ends.
class Outlet {
 public:
  explicit Outlet(OnMessage on_message) : on_message_(std::move(on_message)) {}
  void hand_over(mission::Message&& message) {
    const std::lock_guard lock(mutex_);
    if (on_message_) on_message_(std::move(message));
  }
  void close() {
    const std::lock_guard lock(mutex_);
    on_message_ = {};
  }

 private:
  std::mutex mutex_;
  OnMessage on_message_;
};

/// Holds messages until their random moment has come.
class Waiting {
 public:
  Waiting(std::uint64_t seed, RobotId id)
      : random_(seed, id, "shuffle"), thread_([this](const std::stop_token& stop) { run(stop); }) {}

  void hold(std::shared_ptr<Outlet> outlet, mission::Message&& message) {
    {
      const std::lock_guard lock(mutex_);
      const auto delay = std::chrono::microseconds(random_.below(kLongestDelay_us));
      held_.emplace(Clock::now() + delay, Held{std::move(outlet), std::move(message)});
    }
    changed_.notify_one();
  }

 private:
  struct Held {
    std::shared_ptr<Outlet> outlet;
    mission::Message message;
  };
  static constexpr std::uint64_t kLongestDelay_us = 3000;

  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      if (held_.empty()) {
        changed_.wait(lock, stop, [&] { return !held_.empty(); });
        continue;
      }
      const Clock::time_point due = held_.begin()->first;
      if (Clock::now() < due) {
        changed_.wait_until(lock, stop, due, [&] { return held_.begin()->first < due; });
        continue;
      }
      auto next = held_.extract(held_.begin());
      lock.unlock();
      next.mapped().outlet->hand_over(std::move(next.mapped().message));
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::multimap<Clock::time_point, Held> held_;
  Random random_;
  std::jthread thread_;  // last: uses all of the above
};

class ShuffledReader final : public Reader {
 public:
  ShuffledReader(std::shared_ptr<Outlet> outlet, std::unique_ptr<Reader> inner)
      : outlet_(std::move(outlet)), inner_(std::move(inner)) {}
  ~ShuffledReader() override {
    inner_.reset();
    outlet_->close();
  }
  int matched() const override { return inner_->matched(); }

 private:
  std::shared_ptr<Outlet> outlet_;
  std::unique_ptr<Reader> inner_;
};

class ShuffledParticipant final : public Participant {
 public:
  ShuffledParticipant(std::unique_ptr<Participant> inner, std::uint64_t seed, RobotId id)
      : waiting_(seed, id), inner_(std::move(inner)) {}

  std::unique_ptr<Writer> writer(mission::MessageClass topic, const std::string& partition,
                                 Delivery delivery, OnMatch on_match) override {
    return inner_->writer(topic, partition, delivery, std::move(on_match));
  }

  std::unique_ptr<Reader> reader(mission::MessageClass topic, const std::string& partition,
                                 Delivery delivery, OnMessage on_message,
                                 OnMatch on_match) override {
    auto outlet = std::make_shared<Outlet>(std::move(on_message));
    auto hold = [this, outlet](mission::Message&& m) { waiting_.hold(outlet, std::move(m)); };
    return std::make_unique<ShuffledReader>(
        outlet, inner_->reader(topic, partition, delivery, hold, std::move(on_match)));
  }

 private:
  Waiting waiting_;
  std::unique_ptr<Participant> inner_;
};

}  // namespace

std::unique_ptr<Participant> shuffled(std::unique_ptr<Participant> inner, std::uint64_t seed,
                                      RobotId id) {
  return std::make_unique<ShuffledParticipant>(std::move(inner), seed, id);
}

}  // namespace muster::dds
