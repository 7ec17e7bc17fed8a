#pragma once

#include <vector>

#include "common/core/ids.h"
#include "common/core/time.h"
#include "common/geometry/pose.h"
#include "common/mission/script.h"

namespace muster::commsim {

/// What a mission's script takes from the radio at an instant: jammed spheres, cut pairs, raised
/// loss, paused robots, muted beacons.
class Interference {
 public:
  explicit Interference(const std::vector<mission::ScriptedEvent>& script);

  /// The rest is about this instant.
  void advance(SimTime now);
  bool jams(const Vec3& p) const;
  bool cuts(RobotId a, RobotId b) const;
  bool pauses(RobotId robot) const;
  bool mutes(RobotId robot) const;
  /// At least this share of the messages is lost.
  double loss() const { return loss_; }

 private:
  std::vector<mission::ScriptedEvent> script_, now_;
  double loss_ = 0;
};

}  // namespace muster::commsim
