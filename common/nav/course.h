#pragma once

#include <optional>
#include <vector>

#include "common/nav/limits.h"
#include "common/nav/trajectory.h"

namespace muster::nav {

/// A rounded, subdivided polyline with the yaw and speed limits along it; how fast it is really
/// driven is decided in time_path.
///
///     P0 ──straight──(bend)──straight──straight──(bend)── … ── Pn
///
/// A bend is a quadratic Bézier from d before a corner to d after it, driven at constant parameter
/// rate: a *constant acceleration* w²·sin(θ/2)/d that turns the velocity without changing the speed
/// w at its ends. Straights have constant acceleration phases. So every piece of motion is a
/// parabola in time, cubic Hermite states reproduce it exactly, and limits that hold at the states
/// hold between them.
struct Course {
  struct Piece {
    bool bend = false;
    Vec3 from_dir = Vec3::UnitX(), to_dir = Vec3::UnitX();
    double length_m = 0;  ///< along the polyline; a bend: 2d
    double hard_mps = 0;  ///< centripetal limit of a bend
    double soft_mps =
        0;  ///< speed, sight, yaw rate, look-ahead: a vehicle that is faster now may brake to it
  };
  struct Node {
    double yaw_in_rad = 0;   ///< on arrival, unwrapped
    double yaw_out_rad = 0;  ///< on leaving: when it differs, the vehicle stops here and turns
  };
  std::vector<Piece> pieces;
  std::vector<Node> nodes;  ///< one more than pieces
};

struct CourseRequest {
  std::vector<Vec3> points;  ///< ≥ 2, apart; the first leg points along the velocity
  double speed_mps = 0;      ///< at the first point
  double yaw_rad = 0;        ///< at the first point
  std::optional<double> final_yaw_rad;
  double corner_m = 0.1;
  double max_speed_mps = 2;  ///< after scaling and sight
  bool look_ahead = true;    ///< UAV: along the motion
  bool first_leg_bends =
      false;  ///< the first leg is just long enough for its half of the first bend
};

Course lay_course(const CourseRequest& request, const Limits& limits);

}  // namespace muster::nav
