#pragma once

#include <cstdint>
#include <vector>

namespace muster::route {

/// Who inspects what (S0 IV-C2 III, the MVRP): appends new areas to the ends of running plans so
/// that the largest finishing time, then the total travel, is small. Regret insertion, then moves
/// and swaps; counted work.
struct AllocationProblem {
  std::vector<double> free_at_s;             ///< per inspector: when its present plan ends
  std::vector<std::vector<double>> first_s;  ///< [inspector][area]: travel from the end of its plan
  std::vector<std::vector<double>> between_s;  ///< [area][area]
  std::vector<double> service_s;               ///< per area
};
/// Per inspector, the areas in the order to be visited.
std::vector<std::vector<std::uint32_t>> allocate(const AllocationProblem& problem);

/// The station's tour over pending meetings (TSP with soft time windows): exact dynamic programming
/// up to 12, insertion above.
struct TourProblem {
  double now_s = 0;
  std::vector<std::vector<double>> travel_s;  ///< 0: the station; 1…n: meetings
  std::vector<double> from_s, until_s;        ///< windows, per meeting
  double service_s = 2;
  double late_weight = 10;  ///< cost of a second of lateness, against one of waiting or travel
};
struct Tour {
  std::vector<std::uint32_t> order;  ///< indices 0…n−1 into the meetings
  std::vector<double> arrive_s;
  double cost = 0;
};
Tour plan_tour(const TourProblem& problem);

/// Rolling assignment, (14): how many inspectors each of the given regions gets, by volume, largest
/// remainder, at least one each when possible.
std::vector<std::uint32_t> share_inspectors(std::uint32_t inspectors,
                                            const std::vector<double>& volumes_m3);

}  // namespace muster::route
