#include "agent/agent.h"

#include "agent/strategy/slei3d_explorer.h"
#include "agent/strategy/slei3d_inspector.h"
#include "common/robot/robot.h"

namespace muster::agent {
namespace {

std::unique_ptr<robot::Strategy> make_strategy(const mission::Mission& mission,
                                               const mission::RobotConfig& robot) {
  if (mission.strategy == "slei3d") {
    if (robot.role == mission::Role::kExplorer)
      return std::make_unique<Slei3dExplorer>(mission, robot.id);
    return std::make_unique<Slei3dInspector>();
  }
  throw BadInput(mission.file + ": strategy: '" + mission.strategy + "' has no agents");
}

}  // namespace

std::unique_ptr<mission::Process> make_agent(const mission::Mission& mission, RobotId id,
                                             std::uint64_t epoch) {
  if (!mission.has(id))
    throw BadInput(mission.file + ": fleet: there is no robot " + std::to_string(id.value));
  const mission::RobotConfig& robot = mission.robot(id);
  if (robot.role == mission::Role::kStation) {
    throw BadInput(mission.file + ": fleet: robot " + std::to_string(id.value) +
                   " is a station: muster-gcs runs it");
  }
  return std::make_unique<robot::Robot>(mission, id, make_strategy(mission, robot), epoch);
}

}  // namespace muster::agent
