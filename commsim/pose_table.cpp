#include "commsim/pose_table.h"

namespace muster::commsim {

void PoseTable::hear(const mission::Truth& frame, SimTime now) {
  for (const mission::TrueState& state : frame.robots) {
    const auto known = seen_.find(state.robot);
    const bool news = known == seen_.end() || frame.time > known->second.stamp ||
                      now - known->second.came > kPoseLimit;
    if (news) seen_[state.robot] = {state.pose, frame.time, now};
  }
}

std::optional<Pose> PoseTable::at(RobotId robot, SimTime now) const {
  const auto known = seen_.find(robot);
  if (known == seen_.end() || now - known->second.came > kPoseLimit) return std::nullopt;
  return known->second.pose;
}

}  // namespace muster::commsim
