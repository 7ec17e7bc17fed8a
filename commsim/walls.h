#pragma once

#include "common/geometry/pose.h"
#include "commsim/world/scene.h"

namespace muster::commsim {

/// How many walls a straight line crosses: surfaces that it enters by their front, or leaves by
/// their back if these are more (a sheet without thickness has only one side). A solid wall is one,
/// whatever it is made of. Surfaces within 1 cm of an end do not count.
int walls_between(const world::Scene& scene, const Vec3& a, const Vec3& b);

}  // namespace muster::commsim
