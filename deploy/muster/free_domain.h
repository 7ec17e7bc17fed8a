#pragma once

#include <cstdint>
#include <optional>

namespace muster::command {

/// The DDS domain of the bus: `wished`, or the first pair of domains (bus, air) in 70 … 97 whose
/// hub ports nobody holds. Throws BadInput for a domain beyond 98, Failure when the wished one, or
/// every one, is in use.
std::uint32_t free_domain(std::optional<std::uint32_t> wished);

}  // namespace muster::command
