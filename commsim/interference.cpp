#include "commsim/interference.h"

#include <algorithm>

namespace muster::commsim {

Interference::Interference(const std::vector<mission::ScriptedEvent>& script) : script_(script) {}

void Interference::advance(SimTime now) {
  now_.clear();
  loss_ = 0;
  for (const mission::ScriptedEvent& e : script_) {
    const bool for_good = e.verb == "mute-beacons" && e.at <= now;
    if (for_good || e.in_force(now)) now_.push_back(e);
    if (e.verb == "loss" && e.in_force(now)) loss_ = std::max(loss_, e.value);
  }
}

bool Interference::jams(const Vec3& p) const {
  return std::ranges::any_of(now_, [&](const mission::ScriptedEvent& e) {
    return e.verb == "jam" && (p - e.center).norm() <= e.radius_m;
  });
}

bool Interference::cuts(RobotId a, RobotId b) const {
  return std::ranges::any_of(now_, [&](const mission::ScriptedEvent& e) {
    return e.verb == "cut" && ((e.robot == a && e.other == b) || (e.robot == b && e.other == a));
  });
}

bool Interference::pauses(RobotId robot) const {
  return std::ranges::any_of(now_, [&](const mission::ScriptedEvent& e) {
    return e.verb == "pause" && e.concerns(robot);
  });
}

bool Interference::mutes(RobotId robot) const {
  return std::ranges::any_of(now_, [&](const mission::ScriptedEvent& e) {
    return e.verb == "mute-beacons" && e.concerns(robot);
  });
}

}  // namespace muster::commsim
