#include "agent/agent.h"
#include "deploy/muster/memory_fleet.h"
#include "gcs/station.h"

namespace muster::command {

std::unique_ptr<mission::Process> make_process(const mission::Mission& mission, RobotId id,
                                               std::uint64_t epoch) {
  const bool station = mission.robot(id).role == mission::Role::kStation;
  return station ? gcs::make_station(mission, id, epoch) : agent::make_agent(mission, id, epoch);
}

}  // namespace muster::command
