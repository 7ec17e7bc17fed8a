#pragma once

#include <cstdint>
#include <vector>

namespace muster::route {

/// FF3E, Alg. 1 of S0: an order of frontier viewpoints that uses the time before the next meeting.
struct OrderProblem {
  /// travel_s[i][j]: from i to j; 0 is the robot's own place, 1…n the viewpoints, n+1 the meeting
  /// place (when there is one).
  std::vector<std::vector<double>> travel_s;
  std::vector<double> gain;  ///< per viewpoint 1…n at index 0…n−1
  double budget_s = 0;       ///< time until the meeting; infinity: none
  bool meeting = false;
};
struct Order {
  std::vector<std::uint32_t> visit;  ///< indices 0…n−1 into the viewpoints
  double length_s = 0;               ///< including the way to the meeting
};

/// Exact as written in the paper for the at most `nearest` closest viewpoints (longest path that
/// still makes the meeting; O(n!)): `slei3d`.
Order ff3e(const OrderProblem& problem, std::uint32_t nearest = 7);

/// Shortest open tour over all given viewpoints (start fixed, end free or at the meeting): nearest
/// insertion + 2-opt/or-opt, counted work.
Order shortest_order(const OrderProblem& problem);

}  // namespace muster::route
