#pragma once

#include <map>
#include <optional>

#include "common/core/ids.h"
#include "common/core/time.h"
#include "common/geometry/pose.h"
#include "common/mission/messages.h"

namespace muster::commsim {

/// Where the robots of a lab are, as far as its motion capture has said so of late.
///
/// A pose counts for `kPoseLimit` after it came, by our own clock: nobody knows how the cameras'
/// clock relates to it. A stamp only tells news from repetition: a pose that is not newer than the
/// one before prolongs nothing, so a bridge may go on saying what it last saw. Once a pose has run
/// out any stamp is news: the bridge may have been started again.
class PoseTable {
 public:
  /// Older, and a robot may be anywhere: at 2 m/s a fifth of the papers' radio range away.
  static constexpr Duration kPoseLimit{500'000};

  /// `frame`: of any number of robots. `now` never goes back.
  void hear(const mission::Truth& frame, SimTime now);
  /// nullopt: nobody knows.
  std::optional<Pose> at(RobotId robot, SimTime now) const;

 private:
  struct Seen {
    Pose pose;
    SimTime stamp, came;
  };
  std::map<RobotId, Seen> seen_;
};

}  // namespace muster::commsim
