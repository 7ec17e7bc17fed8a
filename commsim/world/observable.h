#pragma once

#include <compare>
#include <vector>

#include "commsim/world/reachable.h"

namespace muster::world {

/// A voxel of the mission's resolution: floor(coordinate / resolution) along each axis.
struct Voxel {
  int x = 0, y = 0, z = 0;
  auto operator<=>(const Voxel&) const = default;
};

/// The surface voxels inside the mission's boxes that an explorer's camera can see from a reachable
/// place: what `map_coverage` counts against (RULES.md). Sorted. Undersides that a level camera
/// only ever sees too steeply are not among them.
std::vector<Voxel> observable_surface(const Scene& scene, const mission::Mission& mission,
                                      const ReachableSpace& reachable);

}  // namespace muster::world
