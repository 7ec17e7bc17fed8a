#pragma once

#include <vector>

#include "common/robot/knowledge.h"

namespace muster::agent {

/// Poses from which an inspector's level camera sees an area within the inspection rule (range,
/// incidence, field of view, line of sight through known space), body-safe and reachable by the
/// last flood of `knowledge.paths()`; best first: near the robot, near the normal, and not in a
/// direction from which it was refused before (the normal is an estimate). The poses returned look
/// from directions that differ. `attempt` ≥ 0: how many such sets were tried; margins within the
/// rule shrink with it.
std::vector<Pose> view_poses(robot::Knowledge& knowledge, const mission::Area& area, int attempt,
                             const std::vector<Vec3>& refused_from);

}  // namespace muster::agent
