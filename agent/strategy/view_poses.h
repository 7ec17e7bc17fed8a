#pragma once

#include <optional>
#include <vector>

#include "agent/strategy/surface_belief.h"

namespace muster::agent {

/// A pose to look at an area from, and how likely the camera accepts it.
struct ViewPose {
  Pose pose;
  RefusedLook look;  ///< what to remember should it be refused
  double probability = 0;
  bool seen = false;  ///< a sighting came along this very line
};

/// A look that brought nothing: the camera refused it, or it was never reached.
struct VainLook {
  RefusedLook look;
  bool refused = true;
};

/// The pose from which looking at the area is soonest over, counting the way there and, by its
/// probability, another look after a refusal. Body-safe, with line of sight through known space,
/// and reachable by the last flood of `knowledge.paths()`. None: nothing with a fair chance; what
/// is fair shrinks with `attempts` in vain.
std::optional<ViewPose> view_pose(robot::Knowledge& knowledge, const mission::Area& area,
                                  const std::vector<VainLook>& in_vain, int attempts);

/// Where to ask for, about an area: its position, moved a little when features that are known
/// already lie so near that the answer would be about them. Not moved when that would take too
/// much. Whatever is there may lie on another side of the known feature than its sightings say:
/// with `attempt` the spot turns around it.
Vec3 spot_to_ask(const robot::Knowledge& knowledge, const mission::Area& area, int attempt = 0);

/// A feature that was found already lies within the rule's distance of `spot`: a look that does not
/// show it is refused, whatever else is there.
bool known_near(const robot::Knowledge& knowledge, const Vec3& spot);

/// Is the area still in sight of `pose`, by the map as it is now?
bool in_sight(const robot::Knowledge& knowledge, const mission::Area& area, const Pose& pose);

}  // namespace muster::agent
