#pragma once

#include <cstddef>

#include "common/core/time.h"
#include "common/radio/airtime.h"
#include "common/radio/config.h"

namespace muster::radio {

/// How much a robot may say, so that what it and its neighbours say is no more than the air
/// carries: what waits for the air longer than the queue holds it is lost, beacons too.
///
/// Of the airtime that others' beacons leave, everybody who speaks takes an equal share. A message
/// is begun when there is credit and paid for whole, so that a long one is followed by silence.
///
///     air   ▓ beacons ▓│─ mine ─│─ theirs ─│─ theirs ─│ kept free
///
/// Without a bit rate there is nothing to pace.
class Pace {
 public:
  explicit Pace(const ChannelConfig& config) : air_(config), config_(config) {}

  /// How many bytes of records may be begun in this tick (at least one record, unless 0). Once per
  /// tick. `speakers`: how many others were heard speaking of late.
  std::size_t budget(std::size_t speakers);
  /// Something went out.
  void sent(std::size_t bytes);
  /// Something of others came in that nobody can put off: a beacon, an end.
  void heard_beacon(std::size_t bytes);
  /// Records longer than this keep the air from others for too long.
  std::size_t record_bytes() const;

 private:
  Airtime air_;
  ChannelConfig config_;
  double credit_s_ = 0;
  double beacons_s_ = 0;  // of others, in this tick
  double busy_ = 0;       // the share of the air that they take, of late
};

}  // namespace muster::radio
