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

}  // namespace muster::route
