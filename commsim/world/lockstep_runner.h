#pragma once

#include "commsim/world/run_control.h"

namespace muster::world {

/// The world as the master of the barrier, from the first match to the last tick. Returns the exit
/// status of `muster-world`: 0 when the run ended in order, whatever came of the mission.
int run_in_lockstep(const RunnerOptions& options);

}  // namespace muster::world
