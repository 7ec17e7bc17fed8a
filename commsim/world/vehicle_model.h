#pragma once

#include <optional>

#include "common/core/time.h"
#include "common/mission/messages.h"
#include "common/mission/mission.h"
#include "commsim/world/scene.h"

namespace muster::world {

/// Where a trajectory says the vehicle shall be at an instant: cubic Hermite in p, shortest linear
/// in yaw; the first state before the start, the last one at rest after the end.
struct Reference {
  Vec3 p = Vec3::Zero(), v_mps = Vec3::Zero();
  double yaw_rad = 0;
  bool finished = false;
};
Reference sample(const std::vector<mission::TimedState>& states, SimTime t);

/// One simulated vehicle with its autopilot: follows what it was last told as far as its limits
/// allow.
///
///              trajectory            last state reached, land
///     hold ◀──────────────▶ follow ───────────────────────────▶ descend ──▶ down
///      │    empty: brake      ▲                                    ▲          │
///      │                      └───────────── trajectory: take off ─┼──────────┘
///      └── process silent for 1 s, or battery empty: brake, then ──┘
///
/// A trajectory within the limits is followed exactly; what asks for more speed, acceleration or
/// yaw rate than the vehicle has is lagged behind, never jumped to. A UGV moves in the plane, rides
/// `ride_height_m` above the ground, and stops before what is too high to step on.
///
/// Stepped at 0.02 s. Pure: reads no clock; the scene is asked only for the ground below.
class VehicleModel {
 public:
  VehicleModel(const mission::RobotConfig& config, const Scene& scene);

  /// Replaces what was sent before. Refused (false) when the times do not grow or the vehicle
  /// cannot obey (dead, battery empty).
  bool command(const mission::Trajectory& trajectory);
  /// A process that died leaves its autopilot alone: after 1 s of silence it stops, then lands.
  void set_alive(bool alive, SimTime now);
  /// A process that gets no time is silent like a dead one, but what it last said holds: who is
  /// back within the second of patience goes on as if nothing had been, later it finds a vehicle
  /// that stands.
  void set_paused(bool paused, SimTime now);
  /// Without energy the vehicle lands where it is and obeys nobody.
  void set_powered(bool powered) { powered_ = powered; }

  void step(SimTime from, Duration dt);

  const Pose& pose() const { return pose_; }
  /// At this instant; while a trajectory is followed exactly, the trajectory's own.
  const Vec3& velocity_mps() const { return reported_velocity_; }
  double yaw_rate_radps() const { return yaw_rate_; }
  mission::VehicleState state() const;
  /// In the air and clear of its touch-down spot: what `min_clearance_m` is about.
  bool flying() const { return airborne_; }
  /// On the ground, by landing or (UGV) by nature.
  bool resting() const { return phase_ == Phase::kDown; }
  const mission::Vehicle& vehicle() const { return vehicle_; }
  /// UGV: height of the ground it stands on.
  double ground_z() const { return ground_z_; }

 private:
  enum class Phase { kHold, kFollow, kDescend, kDown };

  void track(const Reference& target, Duration dt);
  void turn(double yaw_rad, Duration dt);
  void brake(Duration dt);
  void move(Duration dt);
  void move_on_ground(Duration dt);
  void follow(SimTime from, Duration dt);
  void descend(Duration dt);
  void touch_down();
  bool abandoned(SimTime now) const;

  mission::Vehicle vehicle_;
  const Scene& scene_;
  Pose pose_;
  Vec3 velocity_ = Vec3::Zero();  ///< mean over the last sub-step
  Vec3 reported_velocity_ = Vec3::Zero();
  bool exact_ = false;  ///< in the last sub-step it was where its trajectory says
  double yaw_rate_ = 0;
  Phase phase_ = Phase::kHold;
  std::vector<mission::TimedState> states_;
  bool land_ = false, alive_ = true, powered_ = true, airborne_ = true;
  SimTime silent_since_;
  double ground_z_ = 0;
  double touch_down_z_ = 0;
};

}  // namespace muster::world
