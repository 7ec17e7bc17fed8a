#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/core/time.h"
#include "common/map/voxel_map.h"
#include "common/nav/limits.h"
#include "common/nav/path_finder.h"

namespace muster::nav {

struct State {
  SimTime t;
  Vec3 p = Vec3::Zero(), v_mps = Vec3::Zero();
  double yaw_rad = 0;
};

/// What a vehicle will do, as timed states; between two: cubic Hermite in position, shortest linear
/// in yaw; after the last: hover. The world and the field's drivers interpolate the same way
/// (bus.idl Trajectory).
class Trajectory {
 public:
  Trajectory() = default;
  explicit Trajectory(std::vector<State> states);

  bool empty() const { return states_.empty(); }
  const std::vector<State>& states() const { return states_; }
  SimTime start() const;
  SimTime end() const;
  State at(SimTime t) const;  ///< before start: the first; after the end: the last, at rest

 private:
  std::vector<State> states_;
};

/// How the camera is turned while flying: along the motion (so that what is ahead is seen),
/// reaching `final_yaw` at the end.
struct TimingRequest {
  State now;  ///< where the vehicle is and how it moves at the start
  std::optional<double> final_yaw_rad;
  double speed_scale = 1;  ///< (0, 1]: fly slower
  bool look_ahead = true;  ///< UAV; false: the camera turns as the end wants, whatever the motion
};

/// Times a path within speed, acceleration and yaw-rate limits, from the present state to rest at
/// its end, without stopping at every waypoint: corners are rounded within `corner_m` of the
/// polyline. Never faster than it can stop within what it can see: `see_m` ahead.
Trajectory time_path(const Path& path, const TimingRequest& request, const Limits& limits,
                     double corner_m = 0.1, double see_m = 5);

/// Brakes at full deceleration along the current velocity, then hovers.
Trajectory stop(const State& now, const Limits& limits);

/// Somebody else who moves: an announced trajectory, or a body seen (short-lived obstacle) that may
/// move at up to `speed_mps` any way.
struct Mover {
  RobotId robot = kNoRobot;
  double radius_m = 0.25;
  std::vector<State> announced;  ///< linear between; hover after the last; not empty to be asked

  Vec3 at(SimTime t) const;  ///< where it says it will be
};

struct Unsafe {
  SimTime t;
  Vec3 p = Vec3::Zero();
  std::string with;  ///< "map" | "robot 3" | "obstacle"
  RobotId robot = kNoRobot;
};

/// The body swept along `trajectory` from `from` on, sampled with steps below the clearance:
/// against the map (occupied and unknown), against movers at the same instants (separation ≥ both
/// radii + margin), against short-lived obstacles (spheres). nullopt: safe. FCL's continuousCollide
/// passes through thin walls (FCL 0.7.0), hence sampling; the sphere–voxel distances are exact.
std::optional<Unsafe> check(const Trajectory& trajectory, SimTime from, const map::VoxelMap& map,
                            double radius_m, std::span<const Mover> movers,
                            std::span<const map::Sphere> obstacles, double margin_m = 0.15);
/// The same against movers and obstacles alone: for a way where the body has been.
std::optional<Unsafe> check_others(const Trajectory& trajectory, SimTime from, double radius_m,
                                   std::span<const Mover> movers,
                                   std::span<const map::Sphere> obstacles, double margin_m = 0.15);

}  // namespace muster::nav
