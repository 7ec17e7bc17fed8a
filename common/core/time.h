#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

namespace muster {

/// A span of mission time, exact to a microsecond, so that sums of ticks never drift.
struct Duration {
  std::int64_t us = 0;

  static Duration from_s(double s) { return {std::llround(s * 1e6)}; }
  constexpr double s() const { return static_cast<double>(us) * 1e-6; }
  /// As decimals are written: 1.8, where `s` may say 1.7999999999999998 and has to go on saying so,
  /// since decisions depend on its last bit.
  constexpr double decimal_s() const { return static_cast<double>(us) / 1e6; }
  constexpr auto operator<=>(const Duration&) const = default;
  constexpr Duration operator+(Duration o) const { return {us + o.us}; }
  constexpr Duration operator-(Duration o) const { return {us - o.us}; }
  constexpr Duration operator*(std::int64_t k) const { return {us * k}; }
};

/// An instant of mission time: 0 when the mission starts. Never the wall clock.
struct SimTime {
  std::int64_t us = 0;

  static SimTime from_s(double s) { return {std::llround(s * 1e6)}; }
  constexpr double s() const { return static_cast<double>(us) * 1e-6; }
  constexpr double decimal_s() const { return static_cast<double>(us) / 1e6; }
  constexpr auto operator<=>(const SimTime&) const = default;
  constexpr SimTime operator+(Duration d) const { return {us + d.us}; }
  constexpr SimTime operator-(Duration d) const { return {us - d.us}; }
  constexpr Duration operator-(SimTime o) const { return {us - o.us}; }
};

/// The barrier's step (DESIGN "Time and determinism").
inline constexpr Duration kTick{100'000};

constexpr SimTime time_of_tick(std::uint64_t k) {
  return {static_cast<std::int64_t>(k) * kTick.us};
}

}  // namespace muster
