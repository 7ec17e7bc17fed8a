#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/mission/mission.h"
#include "common/mission/process.h"
#include "commsim/relay.h"
#include "commsim/world/flight.h"
#include "commsim/world/world.h"

namespace muster::command {

/// Makes the robot or station `id` of a mission; `epoch` counts its starts, from 1.
using ProcessFactory = std::function<std::unique_ptr<mission::Process>(
    const mission::Mission&, RobotId, std::uint64_t epoch)>;
/// `agent::make_agent` or `gcs::make_station`, by the robot's role.
std::unique_ptr<mission::Process> make_process(const mission::Mission& mission, RobotId id,
                                               std::uint64_t epoch);

/// A whole fleet inside one process: world, radio and every robot stepped in turn, tick by tick,
/// with the same serialised bytes and in the same order as the barrier gives over DDS (DESIGN "Time
/// and determinism"), so the trace is the same.
class MemoryFleet {
 public:
  /// Throws BadInput when the mission does not fit its scene.
  MemoryFleet(const mission::Mission& mission, const std::shared_ptr<const world::Scene>& scene,
              ProcessFactory factory, const world::FlightConfig& config);
  ~MemoryFleet();

  /// One tick of 0.1 s. Why the run is over, once it is.
  std::optional<std::string> tick();
  /// Robots write their files, the world its own; returns what it and the radio contribute to
  /// summary.json.
  nlohmann::json finish(const std::string& reason);

  world::Flight& flight() { return flight_; }
  std::uint64_t ticks() const { return k_; }

 private:
  bool needs_journal(RobotId robot) const;
  void start(RobotId robot);
  void run_script();
  std::vector<mission::Message> take_air(RobotId robot);
  void count_whole_maps(std::initializer_list<RobotId> met);
  void step_robots(const std::vector<world::World::Samples>& samples);

  const mission::Mission mission_;
  const mission::Mission known_;  ///< to robots
  ProcessFactory factory_;
  std::string out_;
  world::World world_;
  commsim::Relay relay_;
  world::Flight flight_;
  std::map<RobotId, std::unique_ptr<mission::Process>> robots_;
  std::map<RobotId, store::Journal*> journals_;  ///< of those that have one; their process owns it
  std::map<RobotId, std::uint64_t> starts_;
  std::map<RobotId, std::vector<mission::Message>>
      arriving_,  ///< radio deliveries, for the next tick
      waiting_;   ///< what had arrived at who was paused then
  std::map<RobotId, std::vector<mission::Message>> sent_;
  std::vector<mission::Message> commands_;
  std::uint64_t k_ = 0;
  mission::WholeMapBytes whole_maps_;
};

}  // namespace muster::command
