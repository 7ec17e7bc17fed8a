// `muster` whose in-memory robots hop, for the fleet of hoppers in this folder.
#include "deploy/muster/memory_fleet.h"
#include "tests/fleet/hopper.h"

namespace muster::command {

std::unique_ptr<mission::Process> make_process(const mission::Mission& mission, RobotId id,
                                               std::uint64_t epoch) {
  return test::make_hopper(mission, id, epoch);
}

}  // namespace muster::command
