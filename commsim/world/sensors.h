#pragma once

#include <vector>

#include "common/core/random.h"
#include "common/mission/messages.h"
#include "common/mission/mission.h"
#include "commsim/world/surroundings.h"

namespace muster::world {

/// A depth camera or a 2D lidar on one robot. Ray directions in the sensor's own heading are
/// computed once; a sweep turns them by the yaw.
///
/// Noise (SensingConfig), drawn per returning ray in row-major order from the robot's own stream:
/// uniform within ±range_noise_m, plus a Gaussian with 3 σ = depth_noise · distance, clipped at
/// that bound. A return never lies beyond the range: noise is cut there.
class RangeSensor {
 public:
  static RangeSensor depth_camera(const mission::Vehicle& vehicle);
  static RangeSensor lidar(const mission::Vehicle& vehicle);

  bool fitted() const { return view_.range_m > 0; }
  /// All but envelope and time. `ray_ends` receives the noiseless end of every ray when given: what
  /// the referee counts as seen.
  mission::Scan sweep(const Surroundings& around, RobotId self, const Pose& pose,
                      const mission::SensingConfig& noise, Random& random,
                      std::vector<Vec3>* ray_ends = nullptr) const;

 private:
  RangeSensor(mission::SensorKind kind, const FieldOfView& view, double pitch_rad,
              std::uint32_t columns, std::uint32_t rows);

  mission::SensorKind kind_;
  FieldOfView view_;
  double pitch_rad_;
  std::uint32_t columns_, rows_;
  std::vector<Vec3> directions_;
};

/// Which spots an explorer's detector reported at one look: indices into `spots`, and the noisy
/// sightings.
struct Look {
  mission::Sightings
      sightings;  ///< all but envelope and time; ordered by position, so that order tells nothing
  std::vector<std::size_t> reported;
};

/// RULES "Sighting": every spot (true or false alike) in the camera's view, within the sighting
/// range and unoccluded, with the sighting probability; position noise σ per axis.
Look look_for_spots(const Surroundings& around, RobotId self, const Pose& pose,
                    const mission::Vehicle& vehicle, const std::vector<Feature>& spots,
                    const mission::SensingConfig& sensing, Random& random);

}  // namespace muster::world
