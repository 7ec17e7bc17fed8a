#pragma once

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>

namespace muster::dds {

/// Makes sure that a Cyclone reader hears a Fast writer from its first sample on.
///
/// A Cyclone reader takes all that a writer announces with the first heartbeat it hears for
/// history, and drops what of that has not arrived completely: seen as single messages of 1 MB that
/// never came. Fast 2.9 sends a heartbeat when it matches, before such a reader knows the writer,
/// and the next one 50 ms after the first sample, in the middle of the data. Cyclone's request for
/// one is ignored: it counts from 0, and Fast listens from 1.
///
/// So every such match is greeted with an empty sample, which our readers drop. Heartbeats follow
/// it until it is acknowledged, and from then on the match counts.
///
///     match ──▶ greet ──▶ heard? ──yes──▶ settled
///                 ▲         │ no: ask again, for 3 s at most (killed readers never answer)
///       match ────┘
class FastGreeter {
 public:
  /// Called on the greeter's thread, without its locks.
  class Client {
   public:
    virtual void greet() = 0;
    virtual bool heard() = 0;
    virtual void settled() = 0;

   protected:
    ~Client() = default;
  };

  FastGreeter();

  /// Returns at once: also for the middleware's threads.
  void add(Client& writer);
  /// After this, `writer` is not called any more. Not from within a call.
  void remove(Client& writer);

 private:
  using Clock = std::chrono::steady_clock;
  struct Match {
    bool greeted = false;
    Clock::time_point deadline;
  };

  void run(const std::stop_token& stop);
  void look_after(Client& writer);

  std::mutex mutex_;  ///< never held while a writer is called
  std::condition_variable_any changed_;
  std::map<Client*, Match> matches_;
  std::mutex calling_;
  std::jthread thread_;  // last: uses all of the above
};

}  // namespace muster::dds
