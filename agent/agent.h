#pragma once

#include <memory>

#include "common/mission/mission.h"
#include "common/mission/process.h"

namespace muster::agent {

/// An explorer or inspector that follows the mission's strategy. `epoch`: larger at every start of
/// this robot's process (DESIGN "Records"). Throws BadInput when `id` is not in the mission, or is
/// a station.
std::unique_ptr<mission::Process> make_agent(const mission::Mission& mission, RobotId id,
                                             std::uint64_t epoch = 1);

}  // namespace muster::agent
