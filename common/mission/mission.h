#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/core/ids.h"
#include "common/core/time.h"
#include "common/core/yaml.h"
#include "common/geometry/box.h"
#include "common/geometry/camera.h"
#include "common/mission/messages.h"
#include "common/mission/script.h"
#include "common/radio/config.h"

namespace muster::mission {

/// What a vehicle is: deploy/vehicles/*.yaml. Defaults: the small UAV of RULES.md.
struct Vehicle {
  std::string name = "quad";
  bool ground = false;     ///< a UGV: keeps `ride_height_m` above drivable ground
  double radius_m = 0.25;  ///< body: a sphere around the position
  double speed_mps = 2, accel_mps2 = 2, yaw_rate_radps = 1.5;
  double ride_height_m = 0.4;
  double max_step_m = 0.25, max_slope_rad = 0.5;  ///< UGV: what it drives over
  FieldOfView camera;                             ///< depth camera; range 0: none
  std::uint32_t columns = 48, rows = 31;
  double pitch_rad = 0;  ///< camera mount, level by default
  double scan_rate_hz = 2;
  FieldOfView lidar{2 * std::numbers::pi, 0, 0};  ///< range 0: none
  std::uint32_t lidar_columns = 360;
  double capacity_mah = 1000, discharge_mah_per_s = 0;  ///< 0: never runs low

  /// The file's stem is the name. Throws BadInput.
  static Vehicle load(const std::string& path);
  /// Takes what `map` gives over what is here, and checks it. Throws BadInput naming file, line and
  /// key.
  void read(YamlMap& map);
};

struct RobotConfig {
  RobotId id;
  Role role{};
  std::string vehicle_file;
  Vehicle vehicle;
  Pose start;  ///< position of the body's centre
  std::uint32_t skills = 0;
  std::string place;  ///< `file:line: key` of its start, for who checks it against the scene
};

struct SensingConfig {
  double sighting_rate_hz = 0.5, sighting_range_m = 5, sighting_probability = 0.9,
         sighting_sigma_m = 0.1;
  double false_areas = 0.1;     ///< as a share of the features
  double range_noise_m = 0.02;  ///< uniform ±
  double depth_noise = 0.05;    ///< bound (3 σ) relative to depth
};

struct InspectConfig {
  double range_m = 5, max_incidence_rad = std::numbers::pi / 3, max_speed_mps = 0.2, hold_s = 3,
         match_m = 0.5;
  bool shared = false;
  std::uint32_t payload_bytes = 200'000;
};

struct FeatureConfig {
  std::uint32_t count = 150;
  double min_height_m = 1, first_box_weight = 3;
  double priority_share = 0;
};

struct ChargingStation {
  Pose pose;
  std::uint32_t slots = 1;
  double rate_per_s = 0.1;  ///< share of the capacity
  double reach_m = 1;
};

/// Where and when a pair that lost each other can always find each other: `place` at times t0 +
/// j·period, for `window`.
struct StandingConfig {
  Vec3 place = Vec3::Zero();
  Duration t0 = Duration::from_s(300), period = Duration::from_s(120),
           window = Duration::from_s(30);
};

/// A mission file, checked. Everything in it (but the scene's content) is what every robot knows at
/// t = 0.
struct Mission {
  std::string name, file;
  std::string scene_file;  ///< absolute; robots never open it
  bool ground = false;     ///< adds the plane z = 0 under the hull, for meshes that bring none
  Box hull;                ///< the site; also geofence and ceiling
  std::vector<Box> boxes;  ///< bounding boxes; RegionId indexes this
  std::vector<std::string> box_places;  ///< `file:line: key` of each
  std::vector<RobotConfig> fleet;
  std::string strategy = "slei3d";
  std::uint64_t seed = 1;
  double time_limit_s = 3600;
  bool coverage_counts_surface = true;
  StandingConfig standing;
  SensingConfig sensing;
  InspectConfig inspect;
  FeatureConfig features;
  radio::RadioConfig radio;
  std::vector<ChargingStation> charging;
  std::vector<ScriptedEvent> script;
  double meeting_tolerance_s = 10;  ///< δ̄ (S0 IV-D2)
  double battery_reserve = 0.2;
  double lost_contact_s = 600;  ///< unheard this long past its ladder, a robot goes home
  double resolution_m = 0.2;
  double free_ball_m = 1.5;  ///< known free around every start
  double clearance_m = 0.1;  ///< kept between body and the map

  /// Reads and validates. Throws BadInput with file, line and key: unknown keys, duplicate ids, no
  /// station, boxes outside the hull, unknown strategy … (What needs the scene, e.g. a start inside
  /// a wall, is checked by the world.)
  static Mission load(const std::string& path);
  /// Applies one `--set a.b=value`. Throws BadInput.
  static Mission load(const std::string& path, const std::vector<std::string>& overrides);
  /// And adds the script of `faults_file`, unless that is empty.
  static Mission load(const std::string& path, const std::vector<std::string>& overrides,
                      const std::string& faults_file);
  /// What a robot may be told: all but what is going to happen to it.
  Mission without_script() const;
  std::string to_yaml() const;  ///< the effective mission: --print-config

  const RobotConfig& robot(RobotId id) const;  // aborts when unknown
  bool has(RobotId id) const;
  std::vector<RobotId> with_role(Role role) const;
  RobotId station() const;  ///< the first
};

/// The strategies that exist: `slei3d` so far.
const std::vector<std::string>& strategies();

}  // namespace muster::mission
