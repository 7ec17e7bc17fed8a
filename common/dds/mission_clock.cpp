#include "common/dds/mission_clock.h"

#include <algorithm>
#include <cmath>

namespace muster::dds {
namespace {

constexpr std::uint32_t kUnknownStratum = 15;
/// Correction per second: small errors must not disturb a flight; large ones, before or after an
/// outage, must not last.
constexpr double kSlew = 0.01, kFastSlew = 0.1, kLargeError_s = 0.5;
/// Beacons compared with each other, and how long they outrank the drivers.
constexpr double kWindow_s = 5;
/// Silence before a correction counts only so far.
constexpr double kLongestGap_s = 1;

}  // namespace

MissionClock::MissionClock(bool station, double speed)
    : speed_(speed), stratum_(station ? 0 : kUnknownStratum) {}

void MissionClock::slew(double offset_s, double monotonic_s) {
  const double gap_s = std::clamp(monotonic_s - corrected_s_, 0.0, kLongestGap_s);
  const double error_s = offset_s - *offset_s_;
  const double rate = std::abs(error_s) > kLargeError_s ? kFastSlew : kSlew;
  const double most_s = rate * speed_ * gap_s;
  *offset_s_ += std::clamp(error_s, -most_s, most_s);
  corrected_s_ = monotonic_s;
}

void MissionClock::driver_says(double driver_s, double monotonic_s) {
  const double offset_s = driver_s - speed_ * monotonic_s;
  if (!offset_s_) {
    offset_s_ = offset_s;
    corrected_s_ = monotonic_s;
    return;
  }
  if (!heard_.empty() && monotonic_s - heard_.back().monotonic_s < kWindow_s) return;
  slew(offset_s, monotonic_s);
}

void MissionClock::beacon_says(std::uint32_t stratum, double mission_s, double monotonic_s) {
  if (!offset_s_ || stratum >= stratum_) return;
  stratum_ = std::min(stratum_, stratum + 1);
  heard_.push_back({mission_s - speed_ * monotonic_s, monotonic_s});
  while (monotonic_s - heard_.front().monotonic_s > kWindow_s) heard_.pop_front();
  const auto least_delayed =
      std::max_element(heard_.begin(), heard_.end(),
                       [](const Heard& a, const Heard& b) { return a.offset_s < b.offset_s; });
  slew(least_delayed->offset_s, monotonic_s);
}

}  // namespace muster::dds
