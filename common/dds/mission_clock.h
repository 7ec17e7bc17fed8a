#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace muster::dds {

/// Mission time in the field: the monotonic clock plus an offset that is only ever slewed, so that
/// mission time never stands or runs backwards.
///
/// The drivers' first sample sets it. From then on the best source heard of late corrects it: a
/// beacon of a lower stratum (the station is 0; who follows stratum n is n + 1), else the drivers.
/// A beacon arrives late by an unknown while, never early, so among recent ones the one that says
/// the latest time is the least delayed and is believed.
///
/// Pure: the monotonic time comes in as a value. All times in seconds.
class MissionClock {
 public:
  /// `speed`: mission seconds per second, other than 1 only with a simulated world.
  explicit MissionClock(bool station, double speed = 1);

  void driver_says(double driver_s, double monotonic_s);
  void beacon_says(std::uint32_t stratum, double mission_s, double monotonic_s);

  bool set() const { return offset_s_.has_value(); }
  /// Mission time at a monotonic time; after `set`.
  double at(double monotonic_s) const { return *offset_s_ + speed_ * monotonic_s; }
  std::uint32_t stratum() const { return stratum_; }

 private:
  struct Heard {
    double offset_s, monotonic_s;
  };
  void slew(double offset_s, double monotonic_s);

  const double speed_;
  std::uint32_t stratum_;
  std::optional<double> offset_s_;
  double corrected_s_ = 0;   ///< monotonic time of the last correction
  std::deque<Heard> heard_;  ///< from lower strata, of late
};

}  // namespace muster::dds
