#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <vector>

#include "common/dds/participant.h"
#include "common/mission/messages.h"

namespace muster::dds {

/// Where the middleware's threads leave what arrives, and the one thread of a shell picks it up.
/// Never polls.
class Inbox {
 public:
  using Clock = std::chrono::steady_clock;

  void put(mission::Message&& message);
  /// Makes a waiting `take` return, with nothing new.
  void wake();
  OnMessage on_message() {
    return [this](mission::Message&& m) { put(std::move(m)); };
  }
  OnMatch on_match() {
    return [this] { wake(); };
  }

  /// What has arrived since the last call; waits until there is something, somebody calls `wake`,
  /// or the deadline.
  std::vector<mission::Message> take(Clock::time_point deadline);

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<mission::Message> messages_;
  bool woken_ = false;
};

/// So long from now: a deadline for `take`.
inline Inbox::Clock::time_point in(std::chrono::duration<double> d) {
  return Inbox::Clock::now() + std::chrono::duration_cast<Inbox::Clock::duration>(d);
}

}  // namespace muster::dds
