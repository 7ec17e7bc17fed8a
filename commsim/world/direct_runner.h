#pragma once

#include "commsim/world/run_control.h"

namespace muster::world {

/// The world without barrier and radio (`--link direct`): moves on at `speed` times real time with
/// whatever commands have arrived, and overhears the air for the referee, since everybody hears
/// everybody.
int run_direct(const RunnerOptions& options);

}  // namespace muster::world
