#pragma once

#include <vector>

#include "common/robot/knowledge.h"

namespace muster::agent {

/// Poses from which an inspector's level camera sees an area within the inspection rule (range,
/// incidence, field of view, line of sight through known space), body-safe and reachable by the
/// last flood of `knowledge.paths()`; best first (near the robot, near the normal). `attempt` > 0
/// turns and widens the pattern, for areas whose estimated normal proved wrong.
std::vector<Pose> view_poses(robot::Knowledge& knowledge, const mission::Area& area, int attempt);

}  // namespace muster::agent
