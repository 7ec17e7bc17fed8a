// The barrier and nothing else, to measure the middleware: the hub sends a tick, every agent
// answers done, and so on.
//   lockstep_peer VENDOR DOMAIN hub AGENTS TICKS     prints the time to match and the rate
//   lockstep_peer VENDOR DOMAIN agent NUMBER
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "common/dds/convert.h"
#include "common/dds/participant.h"

namespace {

using namespace muster;
using mission::MessageClass;
using Clock = std::chrono::steady_clock;

/// What arrives is queued by the middleware's thread and handled by ours, as in every program of
/// Muster.
class Queue {
 public:
  void push(mission::Message&& message) {
    {
      const std::lock_guard lock(mutex_);
      messages_.push_back(std::move(message));
    }
    changed_.notify_one();
  }
  /// nullopt: nothing came for so long.
  std::optional<mission::Message> pop(Clock::duration patience = std::chrono::seconds(30)) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, patience, [&] { return !messages_.empty(); })) return std::nullopt;
    mission::Message message = std::move(messages_.front());
    messages_.pop_front();
    return message;
  }
  void poke() {
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
  }
  template <class Condition>
  void wait_for(Condition condition) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, condition);
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<mission::Message> messages_;
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

int run_hub(dds::Participant& participant, int agents, std::uint64_t ticks) {
  Queue queue;
  const auto poke = [&] { queue.poke(); };
  const Clock::time_point start = Clock::now();
  const auto reader = participant.reader(
      MessageClass::kDone, dds::kSimPartition, dds::Delivery::kEvery,
      [&](mission::Message&& m) { queue.push(std::move(m)); }, poke);
  const auto writer =
      participant.writer(MessageClass::kTick, dds::kSimPartition, dds::Delivery::kLatest, poke);
  queue.wait_for([&] { return reader->matched() == agents && writer->matched() == agents; });
  std::printf("matched %d in %.2f s\n", agents, seconds_since(start));
  std::fflush(stdout);

  std::set<std::uint32_t> ready;
  while (static_cast<int>(ready.size()) < agents) {
    ready.insert(dds::decode<mission::Done>(queue.pop().value()).process.value);
  }
  std::printf("all ready in %.2f s\n", seconds_since(start));
  std::fflush(stdout);

  mission::Tick tick;
  const auto step = [&] {
    ++tick.k;
    writer->write(dds::encode(tick).cdr);
    for (int waiting = agents; waiting > 0;) {
      if (dds::decode<mission::Done>(queue.pop().value()).k == tick.k) --waiting;
    }
  };
  step();
  const Clock::time_point first = Clock::now();
  while (tick.k < ticks) step();
  std::printf("%.0f ticks/s\n", static_cast<double>(ticks - 1) / seconds_since(first));
  std::fflush(stdout);
  tick.phase = mission::TickPhase::kEnd;
  step();
  return 0;
}

int run_agent(dds::Participant& participant, std::uint32_t number) {
  Queue queue;
  const auto poke = [&] { queue.poke(); };
  const auto writer =
      participant.writer(MessageClass::kDone, dds::kSimPartition, dds::Delivery::kEvery, poke);
  const auto reader = participant.reader(
      MessageClass::kTick, dds::kSimPartition, dds::Delivery::kLatest,
      [&](mission::Message&& m) { queue.push(std::move(m)); }, poke);
  mission::Done done;
  done.process = RobotId{number};
  queue.wait_for([&] { return reader->matched() > 0 && writer->matched() > 0; });
  std::optional<mission::Message> heard;
  do {  // ready, until the hub has heard it
    writer->write(dds::encode(done).cdr);
    heard = queue.pop(std::chrono::milliseconds(100));
  } while (!heard);
  for (;; heard = queue.pop()) {
    const auto tick = dds::decode<mission::Tick>(heard.value());
    done.k = tick.k;
    writer->write(dds::encode(done).cdr);
    if (tick.phase == mission::TickPhase::kEnd) return 0;
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 5) {
    std::fprintf(stderr, "lockstep_peer VENDOR DOMAIN hub AGENTS TICKS | agent NUMBER\n");
    return 2;
  }
  const bool hub = std::string(argv[3]) == "hub";
  const int number = std::atoi(argv[4]);
  dds::ParticipantConfig config;
  config.vendor = dds::vendor_from(argv[1]);
  config.domain = static_cast<std::uint32_t>(std::atoi(argv[2]));
  config.participant = hub ? 0 : static_cast<std::uint32_t>(number);
  const auto participant = dds::make_participant(config);
  if (!hub) return run_agent(*participant, config.participant);
  return run_hub(*participant, number, std::strtoull(argc > 5 ? argv[5] : "1000", nullptr, 10));
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
