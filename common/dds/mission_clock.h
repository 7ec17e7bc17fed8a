#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace muster::dds {

/// Mission time on a robot's own clock: the drivers' clock, and how far the fleet's is ahead of it.
///
///     mission time  =  monotonic clock + drivers' offset  +  ahead
///                      └─ from odometry stamps ─────────┘    └─ from beacons of a lower stratum
///
/// The drivers' first sample sets it. Then the best source heard so far says how far ahead the
/// fleet is (the station is stratum 0; who follows stratum n is n + 1); that stays when it is out
/// of hearing. A beacon arrives late by an unknown while, never early, so among recent ones the one
/// that says the latest time is the least delayed and is believed.
///
/// Mission time never stands or runs backwards. Who finds itself far behind goes on from the right
/// time at once; who finds itself far ahead runs at half speed until it is right, and until then
/// says that it follows nobody. Small errors are slewed away gently.
///
/// Pure: the monotonic time comes in as a value, and never goes back. All times in seconds.
class MissionClock {
 public:
  /// Of who follows nobody.
  static constexpr std::uint32_t kUnknownStratum = 15;

  /// `speed`: mission seconds per second, other than 1 only with a simulated world.
  explicit MissionClock(bool station, double speed = 1);

  void driver_says(double driver_s, double monotonic_s);
  void beacon_says(std::uint32_t stratum, double mission_s, double monotonic_s);
  /// A fault: it is set anew, wrong by so much, and follows nobody. A station, too, then takes the
  /// fleet's time from whom it meets first.
  void skew(double by_s, double monotonic_s);

  bool set() const { return driver_.has_value(); }
  /// Mission time at a monotonic time; this and the rest after `set`.
  double at(double monotonic_s) const;
  /// How far mission time is ahead of the drivers' clock then.
  double ahead(double monotonic_s) const;
  /// What the drivers' clock will say at a mission time that is not before that of `monotonic_s`,
  /// when nothing new is heard.
  double driver_when(double mission_s, double monotonic_s) const;
  /// How far mission time may be from the station's: what is still to be corrected, what beacons
  /// are late, and drift since the last one that counted.
  double bound_s(double monotonic_s) const;
  std::uint32_t stratum(double monotonic_s) const;

 private:
  /// A value on its way to another one.
  struct Slewed {
    double value = 0, goal = 0, since_s = 0;
  };
  struct Heard {
    double ahead_s, monotonic_s;
  };
  static double toward(const Slewed& slewed, double back_rate, double forth_rate, double elapsed_s);
  double offset(double monotonic_s) const;
  void follow(double ahead_s, double monotonic_s);

  const double speed_;
  const bool station_;
  std::uint32_t stratum_;
  std::optional<Slewed> driver_;  ///< drivers' clock minus the monotonic one
  Slewed ahead_;                  ///< mission time minus drivers' clock
  std::deque<Heard> heard_;       ///< from lower strata, of late
  double corrected_s_ = 0;        ///< monotonic time of the last beacon that counted
};

}  // namespace muster::dds
