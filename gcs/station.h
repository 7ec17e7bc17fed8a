#pragma once

#include <memory>

#include "common/mission/mission.h"
#include "common/mission/process.h"

namespace muster::gcs {

/// The mobile ground control station. `epoch` as for agents. Throws BadInput when `id` is not a
/// station of the mission.
std::unique_ptr<mission::Process> make_station(const mission::Mission& mission, RobotId id,
                                               std::uint64_t epoch = 1);

}  // namespace muster::gcs
