#pragma once

#include "common/mission/mission.h"
#include "deploy/muster/run_options.h"

namespace muster::command {

/// `muster run --transport memory`: everything in this process. Returns the exit status.
int run_in_memory(const mission::Mission& mission, const RunOptions& options);

}  // namespace muster::command
