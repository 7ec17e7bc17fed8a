#include "gcs/station.h"

#include "common/robot/robot.h"
#include "gcs/strategy/slei3d_station.h"

namespace muster::gcs {

std::unique_ptr<mission::Process> make_station(const mission::Mission& mission, RobotId id,
                                               std::uint64_t epoch) {
  if (!mission.has(id) || mission.robot(id).role != mission::Role::kStation) {
    throw BadInput(mission.file + ": fleet: there is no station " + std::to_string(id.value));
  }
  if (mission.strategy != "slei3d")
    throw BadInput(mission.file + ": strategy: '" + mission.strategy + "' has no station");
  return std::make_unique<robot::Robot>(mission, id, std::make_unique<Slei3dStation>(mission, id),
                                        epoch);
}

}  // namespace muster::gcs
