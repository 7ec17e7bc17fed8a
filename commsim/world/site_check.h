#pragma once

#include "common/mission/mission.h"
#include "commsim/world/scene.h"

namespace muster::world {

/// What a mission file cannot know without the scene. Throws BadInput, naming the mission's file
/// and what is wrong: a box outside the scene entirely, a robot that starts inside something, too
/// near a surface, or (UGV) above no ground; two robots that overlap.
void check_site(const mission::Mission& mission, const Scene& scene);

/// Inside something solid: along every direction tried, the ray leaves more surfaces through their
/// back than it enters through their front. A room made of single sheets is not solid.
bool inside_solid(const Mesh& mesh, const Vec3& p);

}  // namespace muster::world
