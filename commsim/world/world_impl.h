#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/core/random.h"
#include "commsim/world/activity.h"
#include "commsim/world/collision.h"
#include "commsim/world/coverage.h"
#include "commsim/world/energy.h"
#include "commsim/world/inspection.h"
#include "commsim/world/ledger.h"
#include "commsim/world/sensors.h"
#include "commsim/world/vehicle_model.h"
#include "commsim/world/world.h"

namespace muster::world {

/// The world's parts, shared by its stepping (world.cpp) and its refereeing (world_referee.cpp).
struct World::Impl {
  /// One robot with all that is simulated for it.
  struct Robot {
    Robot(const mission::RobotConfig& config, const mission::Mission& mission, const Scene& scene,
          const std::vector<Feature>& features);

    mission::RobotConfig config;
    VehicleModel vehicle;
    RangeSensor camera, lidar;
    InspectionCamera inspector;
    Random scan_noise, lidar_noise, sighting_noise;
    bool alive = true, paused = false;
    double fastest_mps = 0;  ///< in the last tick
    double way_m = 0;        ///< flown or driven so far
    SimTime moved_at;        ///< when it last moved
    std::vector<mission::Inspected> results;
    std::vector<Vec3> ray_ends;
  };
  struct Lost {
    RobotId robot;
    SimTime at;
    std::optional<SimTime> revived;
    bool journal = false;  ///< lost as well
  };

  Impl(const mission::Mission& mission, std::shared_ptr<const Scene> scene, FeatureSet features,
       const std::vector<Vec3>& surface);

  // ---- stepping
  Robot* find(RobotId id);
  bool scripted(const char* verb, const Robot& robot) const;
  void run_script();
  void refresh_bodies();
  void sample(Robot& robot, std::size_t index, Samples& out);
  void sample_scans(Robot& robot, std::size_t index, Samples& out);
  void sample_sightings(Robot& robot, Samples& out);
  void sample_requests(Robot& robot, Samples& out);
  void execute(const mission::Message& message);
  void execute_on(Robot& robot, const mission::Message& message);
  void substep(SimTime from);
  void check_contacts();
  void look(Robot& robot, SimTime at);
  bool due(const Robot& robot, double rate_hz) const;
  template <class T>
  void send(Samples& out, T message);

  // ---- refereeing
  void account();
  void event(const char* what, nlohmann::json details, SimTime at);
  void violation(const std::string& what);
  void record_answer(RobotId by, const InspectionCamera::Answer& answer);
  void come_back(Lost& lost);
  nlohmann::json features_redone() const;
  bool home() const;
  bool all_landed() const;
  bool parked(const Robot& r) const;

  mission::Mission mission;
  std::shared_ptr<const Scene> scene;
  FeatureSet features;
  std::vector<Feature> spots;  ///< features, then decoys: what a detector may report
  std::vector<Robot> robots;   ///< by id
  Surroundings around;
  Energy energy;
  CollisionChecker contacts;
  FeatureLedger ledger;
  Coverage coverage;
  ActivityMeter activity;

  std::uint64_t tick = 0, sent = 0;
  SimTime now;
  std::vector<mission::OperatorRequest> requests;
  std::vector<nlohmann::json> events;
  std::vector<Lost> lost;
  std::uint32_t collisions = 0, violations = 0;
  bool declared = false;
  bool called_home = false;  // the operator asked everyone to return, land or abort
  std::optional<SimTime> declared_at, covered_at, home_at;
};

}  // namespace muster::world
