#include "common/dds/inbox.h"

#include <utility>

namespace muster::dds {

void Inbox::put(mission::Message&& message) {
  {
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
  }
  arrived_.notify_one();
}

void Inbox::wake() {
  {
    const std::lock_guard lock(mutex_);
    woken_ = true;
  }
  arrived_.notify_one();
}

std::vector<mission::Message> Inbox::take(Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  arrived_.wait_until(lock, deadline, [this] { return !messages_.empty() || woken_; });
  woken_ = false;
  return std::exchange(messages_, {});
}

}  // namespace muster::dds
