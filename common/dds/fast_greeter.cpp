#include "common/dds/fast_greeter.h"

#include <utility>
#include <vector>

#include "common/core/log.h"

namespace muster::dds {
namespace {

constexpr auto kPatience = std::chrono::seconds(3);
constexpr auto kAskAgain = std::chrono::milliseconds(5);

}  // namespace

FastGreeter::FastGreeter() : thread_([this](const std::stop_token& stop) { run(stop); }) {}

void FastGreeter::add(Client& writer) {
  {
    const std::lock_guard lock(mutex_);
    matches_[&writer] = {.greeted = false, .deadline = Clock::now() + kPatience};
  }
  changed_.notify_all();
}

void FastGreeter::remove(Client& writer) {
  const std::lock_guard done(calling_);
  const std::lock_guard lock(mutex_);
  matches_.erase(&writer);
}

void FastGreeter::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    changed_.wait(lock, stop, [&] { return !matches_.empty(); });
    std::vector<Client*> writers;
    for (const auto& [writer, match] : matches_) writers.push_back(writer);
    lock.unlock();
    for (Client* writer : writers) look_after(*writer);
    lock.lock();
    changed_.wait_for(lock, stop, kAskAgain, [] { return false; });
  }
}

void FastGreeter::look_after(Client& writer) {
  const std::lock_guard calling(calling_);
  bool greeted = false;
  Clock::time_point deadline;
  {
    const std::lock_guard lock(mutex_);
    const auto found = matches_.find(&writer);
    if (found == matches_.end()) return;  // removed meanwhile
    greeted = std::exchange(found->second.greeted, true);
    deadline = found->second.deadline;
  }
  if (!greeted) return writer.greet();
  const bool heard = writer.heard();
  if (!heard && Clock::now() < deadline) return;
  if (!heard) log::debug("fastdds: a matched reader does not answer");
  {
    const std::lock_guard lock(mutex_);
    const auto found = matches_.find(&writer);
    if (!found->second.greeted) return;  // another reader has matched meanwhile
    matches_.erase(found);
  }
  writer.settled();
}

}  // namespace muster::dds
