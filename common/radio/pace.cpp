#include "common/radio/pace.h"

#include <algorithm>

namespace muster::radio {
namespace {

constexpr std::size_t kUnlimited_bytes = std::size_t{256} * 1024;  // per tick: about 20 Mbit/s
constexpr std::size_t kLongest_bytes = 15'000;                     // of a record on any radio
constexpr double kUse = 0.93;  // of the air: who is heard late is counted late
constexpr double kAtOnce_s =
    0.035;  // of a queue of 0.2 s: four may begin at once, and have beacons
constexpr double kMemory_ticks = 20;  // of others' beacons

}  // namespace

std::size_t Pace::budget(std::size_t speakers) {
  if (!air_.limited()) return kUnlimited_bytes;
  busy_ += (beacons_s_ / kTick.s() - busy_) / kMemory_ticks;
  beacons_s_ = 0;
  const double share_s =
      kTick.s() * std::max(0.0, kUse - busy_) / static_cast<double>(speakers + 1);
  credit_s_ = std::min(credit_s_ + share_s, share_s + 0.5 * kAtOnce_s);
  if (credit_s_ <= 0) return 0;
  const double frame_s = air_.of(config_.frame_bytes).s();
  return std::max<std::size_t>(1,
                               static_cast<std::size_t>(credit_s_ / frame_s * config_.frame_bytes));
}

void Pace::sent(std::size_t bytes) { credit_s_ -= air_.of(bytes).s(); }

void Pace::heard_beacon(std::size_t bytes) { beacons_s_ += air_.of(bytes).s(); }

std::size_t Pace::record_bytes() const {
  if (!air_.limited()) return kLongest_bytes;
  const auto frames =
      static_cast<std::size_t>(std::max(1.0, kAtOnce_s / air_.of(config_.frame_bytes).s()));
  return std::min(kLongest_bytes, frames * config_.frame_bytes);
}

}  // namespace muster::radio
