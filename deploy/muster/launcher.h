#pragma once

#include "common/mission/mission.h"
#include "deploy/muster/run_options.h"

namespace muster::command {

/// `muster run` with a process per robot: starts world, radio, station and agents, watches over
/// them, and brings everything to an end whatever happens to any of them. Returns the exit status.
int run_over_dds(const mission::Mission& mission, const RunOptions& options);

}  // namespace muster::command
