#include "common/radio/airtime.h"

#include <algorithm>

namespace muster::radio {

Duration Airtime::of(std::size_t bytes) const {
  if (!limited()) return {};
  const std::size_t frames =
      std::max<std::size_t>(1, (bytes + config_.frame_bytes - 1) / config_.frame_bytes);
  const double bits_us = 8 * static_cast<double>(bytes) / config_.bit_rate_mbps;
  return {std::llround(bits_us + static_cast<double>(frames) * config_.frame_overhead_us)};
}

std::optional<SimTime> Airtime::send(RobotId sender, std::span<const RobotId> hearers, SimTime now,
                                     std::size_t bytes) {
  if (!limited()) return now;
  SimTime start = std::max(now, busy_until_[sender]);
  for (const RobotId robot : hearers) start = std::max(start, busy_until_[robot]);
  if (start - now > Duration::from_s(config_.queue_ms * 1e-3)) return std::nullopt;
  const SimTime end = start + of(bytes);
  busy_until_[sender] = end;
  for (const RobotId robot : hearers) busy_until_[robot] = end;
  return end;
}

}  // namespace muster::radio
