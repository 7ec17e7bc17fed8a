#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/map/targets.h"
#include "common/mission/messages.h"

namespace muster::robot {

class Knowledge;

/// What a strategy wants its body to do now. Wanting the same again changes nothing; a new want
/// replaces the old one at once.
struct Intent {
  enum class Kind {
    kHover,    ///< stay
    kGo,       ///< be at `goal`, within `tolerance_m`
    kInspect,  ///< be at `goal`, turned to its yaw, and hold the camera on `area_position`
    kLand,     ///< go to `goal` and land there
  };
  Kind kind = Kind::kHover;
  Pose goal;
  bool use_yaw = false;  ///< turn to `goal.yaw_rad` on arrival
  double tolerance_m = 0.3;
  bool through_unknown = false;  ///< transit: sense the way where none is known
  mission::AreaRef area;
  Vec3 area_position = Vec3::Zero();
  mission::Activity activity = mission::Activity::kIdle;
  RobotId with = kNoRobot;
  std::string reason;  ///< one line: why (for people)
};

/// How the body is getting on with the present intent.
struct Progress {
  enum class State { kIdle, kMoving, kArrived, kBlocked };
  State state = State::kIdle;
  std::string reason;    ///< of kBlocked
  double blocked_s = 0;  ///< for how long without a break
  std::optional<mission::Inspected>
      inspected;  ///< the answer to an inspection, in the step in which it came
};

/// The deciding half of a robot: reads what is known, writes records of its own through Knowledge,
/// says what it wants. Called once per tick; must be cheap when nothing changed.
class Strategy {
 public:
  virtual ~Strategy() = default;
  virtual void on_sightings(Knowledge&, const mission::Sightings&) {}
  virtual void on_scan(Knowledge&, const mission::Scan&) {}
  virtual Intent decide(Knowledge& knowledge, const Progress& progress) = 0;
  /// The mission is over for this robot's owner (the station's word; others never declare).
  virtual bool declares_complete() const { return false; }
  /// Wall-clock costs of planning steps since the last call.
  std::vector<mission::PlanningTime> take_planning() { return std::exchange(planning_, {}); }

 protected:
  std::vector<mission::PlanningTime> planning_;
};

}  // namespace muster::robot
