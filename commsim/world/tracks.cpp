#include "commsim/world/tracks.h"

#include <fmt/format.h>

namespace muster::world {

std::string track_row(SimTime now, const mission::TrueState& robot) {
  const Vec3& p = robot.pose.p;
  return fmt::format("{:.1f},{},{:.3f},{:.3f},{:.3f},{:.3f}", now.s(), robot.robot.value, p.x(),
                     p.y(), p.z(), robot.pose.yaw_rad);
}

}  // namespace muster::world
