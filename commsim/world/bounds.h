#pragma once

#include <vector>

#include "common/mission/mission.h"
#include "commsim/world/scene.h"

namespace muster::world {

/// No fleet with this mission's settings can have delivered all features earlier (FIELD-NOTES 4):
/// the larger of
///   reach:   the farthest feature from its nearest inspector, less the camera's range, at full
///   speed, plus t_q; service: (a spanning forest over viewing spheres at full speed + t_q per area
///   that needs its own look) / inspectors.
/// Straight lines and no time for communication, so it is a bound, not an estimate. 0 without
/// features or inspectors.
double lower_bound_s(const mission::Mission& mission, const std::vector<Feature>& features);

}  // namespace muster::world
