#pragma once

#include <cstdint>
#include <vector>

namespace muster::route {

/// Rolling assignment, (14): how many inspectors each of the given regions gets, by volume, largest
/// remainder, at least one each when possible.
std::vector<std::uint32_t> share_inspectors(std::uint32_t inspectors,
                                            const std::vector<double>& volumes_m3);

}  // namespace muster::route
