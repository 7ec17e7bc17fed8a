#pragma once

#include "common/nav/limits.h"
#include "common/nav/trajectory.h"

namespace muster::nav {

// How near two moving bodies come to each other. What somebody announces is no promise not to
// brake: whoever follows closely must still be able to brake, too. Gaps are between surfaces, in
// metres; negative: inside one another.

/// The least gap between us on `own` and `other` as announced, over `span` from `from` on.
double least_gap(const Trajectory& own, double radius_m, const Mover& other, SimTime from,
                 Duration span);

/// How fast `mover` goes at `now`, by its announcement.
double speed(const Mover& mover, SimTime now);

/// `mover`, if it brakes at `now` with all it has.
Mover braking(const Mover& mover, SimTime now, const Limits& limits);

/// What we fly if we go on along `own` for `reaction` more, and then brake with all we have.
Trajectory braking_late(const Trajectory& own, SimTime now, Duration reaction,
                        const Limits& limits);

}  // namespace muster::nav
