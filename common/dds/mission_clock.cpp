#include "common/dds/mission_clock.h"

#include <algorithm>
#include <cmath>

namespace muster::dds {
namespace {

/// Correction per second: small errors must not disturb a flight; large ones, before or after an
/// outage, must not last.
constexpr double kSlew = 0.01, kFastSlew = 0.1, kLargeError_s = 0.5;
/// Who is far ahead of the fleet loses so much per second: at half speed beacons are still said
/// often enough for contacts to last.
constexpr double kHoldBack = 0.5;
/// Beacons compared with each other.
constexpr double kWindow_s = 5;
/// Two quartzes apart, and what a beacon is late at most where all goes well (a tick at either
/// end): per stratum.
constexpr double kDrift = 200e-6, kLate_s = 0.2;

}  // namespace

MissionClock::MissionClock(bool station, double speed)
    : speed_(speed), station_(station), stratum_(station ? 0 : kUnknownStratum) {}

/// Fast until the error is small, then gently.
double MissionClock::toward(const Slewed& slewed, double back_rate, double forth_rate,
                            double elapsed_s) {
  double value = slewed.value;
  const double error = slewed.goal - value, rate = error < 0 ? back_rate : forth_rate;
  if (std::abs(error) > kLargeError_s) {
    const double fast_s = std::min(elapsed_s, (std::abs(error) - kLargeError_s) / rate);
    value += std::copysign(rate * fast_s, error);
    elapsed_s -= fast_s;
  }
  const double most = kSlew * elapsed_s;
  return value + std::clamp(slewed.goal - value, -most, most);
}

double MissionClock::offset(double monotonic_s) const {
  return toward(*driver_, kFastSlew, kFastSlew, speed_ * (monotonic_s - driver_->since_s));
}

double MissionClock::ahead(double monotonic_s) const {
  return toward(ahead_, kHoldBack, kFastSlew, speed_ * (monotonic_s - ahead_.since_s));
}

double MissionClock::at(double monotonic_s) const {
  return offset(monotonic_s) + speed_ * monotonic_s + ahead(monotonic_s);
}

/// Mission time grows with the drivers', never slower than `kHoldBack` lets it: halving finds it.
double MissionClock::driver_when(double mission_s, double monotonic_s) const {
  const double driver_s = offset(monotonic_s) + speed_ * monotonic_s;
  const auto ahead_at = [&](double s) { return ahead(monotonic_s + (s - driver_s) / speed_); };
  const double now = ahead(monotonic_s);
  if (now == ahead_.goal || mission_s <= driver_s + now) return mission_s - now;
  double low = mission_s - std::max(now, ahead_.goal),
         high = mission_s - std::min(now, ahead_.goal);
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (middle + ahead_at(middle) < mission_s ? low : high) = middle;
  }
  return high;
}

double MissionClock::bound_s(double monotonic_s) const {
  const double owed_s = std::abs(ahead_.goal - ahead(monotonic_s));
  if (stratum_ == 0) return owed_s;  // the station's time is right by definition
  const double late_s = stratum_ == kUnknownStratum ? 0 : kLate_s * stratum_;
  return owed_s + late_s + kDrift * speed_ * (monotonic_s - corrected_s_);
}

std::uint32_t MissionClock::stratum(double monotonic_s) const {
  const bool far_off = std::abs(ahead_.goal - ahead(monotonic_s)) > kLargeError_s;
  return far_off ? kUnknownStratum : stratum_;
}

void MissionClock::driver_says(double driver_s, double monotonic_s) {
  const double goal = driver_s - speed_ * monotonic_s;
  if (driver_) {
    driver_ = Slewed{offset(monotonic_s), goal, monotonic_s};
  } else {
    driver_ = Slewed{goal, goal, monotonic_s};
    ahead_.since_s = corrected_s_ = monotonic_s;
  }
}

void MissionClock::beacon_says(std::uint32_t stratum, double mission_s, double monotonic_s) {
  if (!driver_ || stratum >= stratum_) return;
  // What a station takes up is the fleet's time, and from then on its own.
  const std::uint32_t mine = station_ ? 0 : stratum + 1;
  if (mine < stratum_) heard_.clear();  // from better sources now
  stratum_ = std::min(stratum_, mine);
  const double driver_s = offset(monotonic_s) + speed_ * monotonic_s;
  heard_.push_back({mission_s - driver_s, monotonic_s});
  while (monotonic_s - heard_.front().monotonic_s > kWindow_s) heard_.pop_front();
  const auto least_delayed =
      std::max_element(heard_.begin(), heard_.end(),
                       [](const Heard& a, const Heard& b) { return a.ahead_s < b.ahead_s; });
  follow(least_delayed->ahead_s, monotonic_s);
  corrected_s_ = monotonic_s;
}

void MissionClock::follow(double ahead_s, double monotonic_s) {
  const double now = ahead(monotonic_s);
  const bool far_behind = ahead_s - now > kLargeError_s;
  ahead_ = {far_behind ? ahead_s : now, ahead_s, monotonic_s};
}

void MissionClock::skew(double by_s, double monotonic_s) {
  follow(ahead_.goal + by_s, monotonic_s);
  heard_.clear();
  stratum_ = kUnknownStratum;
}

}  // namespace muster::dds
