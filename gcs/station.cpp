#include "gcs/station.h"

#include "common/robot/robot.h"
#include "gcs/contact_log.h"
#include "gcs/results_db.h"
#include "gcs/strategy/slei3d_station.h"

namespace muster::gcs {
namespace {

/// A robot whose store is the mission's product.
class Station : public robot::Robot {
 public:
  using robot::Robot::Robot;

  mission::StepOutput step(const mission::StepInput& input) override {
    mission::StepOutput output = robot::Robot::step(input);
    contacts_.update(knowledge());
    return output;
  }

  void finish(const std::string& dir) override {
    robot::Robot::finish(dir);
    write_results(knowledge(), contacts_.contacts(), dir + "/station.db");
    knowledge().map().write_bt(dir + "/map.bt");
  }

 private:
  ContactLog contacts_;
};

}  // namespace

std::unique_ptr<mission::Process> make_station(const mission::Mission& mission, RobotId id,
                                               std::uint64_t epoch) {
  if (!mission.has(id) || mission.robot(id).role != mission::Role::kStation) {
    throw BadInput(mission.file + ": fleet: there is no station " + std::to_string(id.value));
  }
  if (mission.strategy != "slei3d")
    throw BadInput(mission.file + ": strategy: '" + mission.strategy + "' has no station");
  return std::make_unique<Station>(mission, id, std::make_unique<Slei3dStation>(mission, id),
                                   epoch);
}

}  // namespace muster::gcs
