#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "common/mission/messages.h"
#include "common/mission/mission.h"
#include "commsim/world/scene.h"

namespace muster::world {

/// The simulated place, vehicles, sensors, batteries and the referee, as a pure core stepped from
/// outside:
///
///     begin_tick(k) ─▶ bus samples per robot, truth ─▶ … robots think …
///     end_tick(k)   ◀─ their bus messages;  then k+1
///
/// A tick is 0.1 s; vehicles and collisions sub-step at 0.02 s inside `end_tick`.
class World {
 public:
  /// Throws BadInput when the mission does not fit the scene (box outside it, start inside a wall
  /// …).
  World(const mission::Mission& mission, std::shared_ptr<const Scene> scene);
  /// With given features, and given centres of the surface voxels that count for `map_coverage`,
  /// instead of drawn ones.
  World(const mission::Mission& mission, std::shared_ptr<const Scene> scene, FeatureSet features,
        const std::vector<Vec3>& surface);
  ~World();

  struct Samples {
    RobotId robot;
    std::vector<mission::Message> messages;  ///< encoded; src kWorldId, n per world
  };
  /// What every live robot's drivers measure at tick k, in order of robot id, and the poses that
  /// the radio decides on.
  std::vector<Samples> begin_tick(std::uint64_t k);
  mission::Truth truth() const;

  /// Commands of tick k (encoded Trajectory, Inspect, Charge), sorted by (src, n) by the caller;
  /// then 0.1 s of motion.
  void end_tick(std::uint64_t k, const std::vector<mission::Message>& commands);

  /// A robot's process died or came back (between ticks); without its journal, if the script says
  /// so: then what nobody else has is gone.
  void set_alive(RobotId robot, bool alive);
  /// The operator asks something of the station: part of its samples at the next tick.
  void operator_request(mission::RequestVerb verb, RobotId robot);
  /// Scripted operator requests are made by the world itself; scripted kills and revivals are the
  /// launcher's: those due at tick k.
  std::vector<mission::ScriptedEvent> scripted(std::uint64_t k) const;
  /// Who gets no tick k, by the script: such a robot is neither stepped nor heard of.
  std::set<RobotId> paused(std::uint64_t k) const;

  // ---- referee (RULES.md); fed by whoever sees the station's map and records
  /// What the station holds now: newly delivered findings and inspections, and its map blocks
  /// (known voxels), by the records it received.
  void station_received(const store::Record& record, mission::MessageClass cls);
  void station_declares_complete();

  struct Progress {
    double map_coverage = 0;
    std::uint32_t features_total = 0, features_found = 0, features_inspected = 0,
                  features_delivered = 0;
    std::uint32_t collisions = 0;
    bool declared = false, all_landed = false;
  };
  Progress progress() const;
  /// The referee's part of summary.json, and rows of features.csv; `events` since the last call for
  /// events.jsonl.
  nlohmann::json summary() const;
  std::string features_csv() const;
  std::vector<nlohmann::json> take_events();
  /// Folds the true states of the current tick.
  std::uint64_t trace() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace muster::world
