#pragma once

#include <cstdint>
#include <memory>

#include "common/dds/participant.h"

namespace muster::dds {

/// A test switch: hands over what `inner` receives late (up to a few ms of wall time) and out of
/// order, from a thread of its own. A lock-step run must have the same trace with it, because
/// nothing acts on arrival.
std::unique_ptr<Participant> shuffled(std::unique_ptr<Participant> inner, std::uint64_t seed,
                                      RobotId id);

}  // namespace muster::dds
