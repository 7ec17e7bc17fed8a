#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace muster::route {

/// The weight of lateness that makes a window hard.
inline constexpr double kNeverLate = std::numeric_limits<double>::infinity();

/// Something to be done at one place within a window of time: who comes earlier waits until
/// `from_s`, who comes after `until_s` is late.
struct Stop {
  double from_s = 0, until_s = std::numeric_limits<double>::infinity();
  double service_s = 0;             ///< stays so long, from its beginning
  double late_weight = kNeverLate;  ///< cost of a second of lateness; kNeverLate: a hard window
};

/// The travelling salesman's problem with time windows, hard and soft (S0.10: "TSP-TW", which the
/// paper leaves out for space). The tour visits every stop once and costs
///
///     travel  +  wait_weight · waiting  +  Σ late_weight · lateness      [seconds of travel]
///
/// | weights                              | what it is                                          |
/// |--------------------------------------|-----------------------------------------------------|
/// | wait 0, late kNeverLate              | TSPTW as in the literature: least sum of travel     |
/// | wait 1, late kNeverLate              | the same, ready as early as possible                |
/// | wait 1, late w                       | a station's meetings: whoever waits for it costs w  |
struct TourProblem {
  double now_s = 0;
  /// Seconds from place to place. 0: where the tour begins; 1…n: the stops; n + 1: the `end`, if
  /// there is one. Need not be symmetric. Infinite: no way; a soft stop is then ages late.
  std::vector<std::vector<double>> travel_s;
  std::vector<Stop> stops;
  std::optional<Stop> end = {};  ///< where the tour ends, e.g. where it began
  double wait_weight = 0;        ///< of [0, 1]: more would make detours a way to wait
  /// Work at most, in tours begun and looked at (about 10 million a second). Up to 14 stops it is
  /// not limited.
  std::uint64_t max_labels = 4'000'000;
};

struct Tour {
  std::vector<std::uint32_t> order;  ///< indices 0…n−1 into the stops
  std::vector<double> arrive_s;      ///< per stop of `order`, and at the end, if there is one
  double travel_s = 0, wait_s = 0;
  double late_s = 0;  ///< sum over soft stops; hard ones are never late
  double cost = 0;
  double bound = 0;  ///< no tour costs less; equal to `cost`: proven to be the best
};

/// The best tour: exactly up to 14 stops, and above as well when its work suffices (it often does
/// where windows are narrow). nullopt: no tour that keeps the hard windows was found. Of equally
/// good tours the first by dynamic programming over stops in their order. At most 256 stops.
std::optional<Tour> plan_tour(const TourProblem& problem);

}  // namespace muster::route
