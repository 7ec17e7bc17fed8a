#pragma once

#include <memory>

#include "common/mission/mission.h"
#include "commsim/world/scene.h"
#include "deploy/muster/run_options.h"

namespace muster::command {

/// `muster run --transport memory`: everything in this process. Returns the exit status.
int run_in_memory(const mission::Mission& mission, const std::shared_ptr<const world::Scene>& scene,
                  const RunOptions& options);

}  // namespace muster::command
