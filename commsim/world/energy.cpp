#include "commsim/world/energy.h"

#include <algorithm>

namespace muster::world {

Energy::Energy(const mission::Mission& mission)
    : stations_(mission.charging), queues_(mission.charging.size()) {
  std::vector<mission::RobotConfig> fleet = mission.fleet;
  std::sort(fleet.begin(), fleet.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  for (const mission::RobotConfig& r : fleet) {
    robots_.push_back({{}, r.vehicle.capacity_mah, r.vehicle.discharge_mah_per_s});
  }
}

void Energy::ask(std::size_t robot, std::int32_t station) {
  Battery& battery = robots_[robot].battery;
  const bool known = station >= 0 && static_cast<std::size_t>(station) < stations_.size();
  if (known && battery.station == station) return;
  for (auto& queue : queues_) std::erase(queue, robot);
  battery.charging = false;
  battery.station = known ? station : -1;
  if (known) queues_[static_cast<std::size_t>(station)].push_back(robot);
}

void Energy::step(const std::vector<Use>& uses, Duration dt) {
  for (std::size_t i = 0; i < robots_.size(); ++i) discharge(robots_[i], uses[i].resting, dt);
  for (std::size_t s = 0; s < stations_.size(); ++s) charge(s, uses, dt);
}

void Energy::discharge(Robot& robot, bool resting, Duration dt) {
  if (resting || robot.discharge_mah_per_s <= 0 || robot.capacity_mah <= 0) return;
  const double used = robot.discharge_mah_per_s / robot.capacity_mah * dt.s();
  robot.battery.charge = std::max(0.0, robot.battery.charge - used);
}

void Energy::charge(std::size_t station, const std::vector<Use>& uses, Duration dt) {
  const mission::ChargingStation& s = stations_[station];
  std::uint32_t taken = 0;
  const std::deque<std::size_t> queue = queues_[station];
  for (const std::size_t robot : queue) {
    Battery& battery = robots_[robot].battery;
    const bool in_reach = (uses[robot].p - s.pose.p).norm() <= s.reach_m;
    if (battery.charging && !in_reach) {
      leave(robot);  // it went away
      continue;
    }
    battery.charging = in_reach && taken < s.slots;
    if (!battery.charging) continue;
    ++taken;
    battery.charge = std::min(1.0, battery.charge + s.rate_per_s * dt.s());
    if (battery.charge >= 1) leave(robot);
  }
}

}  // namespace muster::world
