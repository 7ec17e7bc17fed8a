#pragma once

#include <map>
#include <optional>
#include <span>

#include "common/core/ids.h"
#include "common/core/time.h"
#include "common/radio/config.h"

namespace muster::radio {

/// The air as a shared thing: while a robot sends, everybody who hears it neither sends nor hears
/// another. A sender waits until the air is free where it is and where it is heard, so nobody ever
/// has more airtime around it than there is time, and those out of each other's reach do not
/// disturb each other. (Real senders cannot know about the far side and collide there instead; the
/// air is spent either way.)
///
///     A  ██████──────██      A and B hear each other: they take turns
///     B  ──────██████──
///     C  ███████████───      hears neither
class Airtime {
 public:
  explicit Airtime(const ChannelConfig& config) : config_(config) {}

  /// Without a bit rate nothing takes time and no order matters.
  bool limited() const { return config_.bit_rate_mbps > 0; }
  /// Its bits at the bit rate, and every frame's overhead.
  Duration of(std::size_t bytes) const;
  /// Sends a message at `now` or as soon as the air is free; when its last bit is on air, or
  /// nullopt when it would have had to wait longer than the queue holds it. Times that are asked
  /// for may go back as far as a tick, never what was granted.
  std::optional<SimTime> send(RobotId sender, std::span<const RobotId> hearers, SimTime now,
                              std::size_t bytes);

 private:
  ChannelConfig config_;
  std::map<RobotId, SimTime> busy_until_;
};

}  // namespace muster::radio
