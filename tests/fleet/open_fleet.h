#pragma once

#include <map>
#include <optional>
#include <string>

#include "common/mission/mission.h"
#include "common/robot/robot.h"
#include "deploy/muster/memory_fleet.h"

namespace muster::test {

/// A fleet in memory whose robots can be looked into. Writes no files.
class OpenFleet {
 public:
  explicit OpenFleet(const mission::Mission& mission)
      : mission_(mission),
        fleet_(mission, world::Scene::load(mission),
               [this](const mission::Mission& m, RobotId id, std::uint64_t epoch) {
                 auto process = command::make_process(m, id, epoch);
                 robots_[id] = dynamic_cast<const robot::Robot*>(process.get());
                 return process;
               },
               {}) {}

  /// As MemoryFleet's. Whom the script kills is gone afterwards.
  std::optional<std::string> tick() {
    std::optional<std::string> end = fleet_.tick();
    for (const mission::ScriptedEvent& event : mission_.script) {
      if (event.verb == "kill" && event.due_at(fleet_.ticks() - 1)) robots_.erase(event.robot);
    }
    return end;
  }
  nlohmann::json finish(const std::string& reason) { return fleet_.finish(reason); }

  /// By the world's clock.
  SimTime now() { return fleet_.flight().now(); }
  const mission::Mission& mission() const { return mission_; }
  /// Who lives.
  const std::map<RobotId, const robot::Robot*>& robots() const { return robots_; }
  const robot::Knowledge& knowledge(RobotId id) const { return robots_.at(id)->knowledge(); }

 private:
  const mission::Mission mission_;
  std::map<RobotId, const robot::Robot*> robots_;  // of `fleet_`, which makes them
  command::MemoryFleet fleet_;
};

}  // namespace muster::test
