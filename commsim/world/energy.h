#pragma once

#include <deque>
#include <vector>

#include "common/core/time.h"
#include "common/mission/mission.h"

namespace muster::world {

/// Batteries and charging stations. A robot that asks for a station and is within its reach takes a
/// free slot, or waits in the order of asking; it leaves by asking for −1, by going out of reach,
/// or when it is full.
class Energy {
 public:
  explicit Energy(const mission::Mission& mission);

  struct Battery {
    double charge = 1;  ///< 0 … 1
    bool charging = false;
    std::int32_t station = -1;  ///< in use, or waited for
  };
  const Battery& battery(std::size_t robot) const { return robots_[robot].battery; }
  /// What nature would not do: a script drains (or fills) it.
  void set_charge(std::size_t robot, double charge) { robots_[robot].battery.charge = charge; }

  /// Robots are indices into the fleet in the world's order. An unknown station counts as −1.
  void ask(std::size_t robot, std::int32_t station);
  void leave(std::size_t robot) { ask(robot, -1); }

  struct Use {
    Vec3 p = Vec3::Zero();
    bool resting = false;  ///< motors off: nothing is discharged
  };
  void step(const std::vector<Use>& uses, Duration dt);

 private:
  struct Robot {
    Battery battery;
    double capacity_mah = 0, discharge_mah_per_s = 0;
  };
  void discharge(Robot& robot, bool resting, Duration dt);
  void charge(std::size_t station, const std::vector<Use>& uses, Duration dt);

  std::vector<Robot> robots_;
  std::vector<mission::ChargingStation> stations_;
  std::vector<std::deque<std::size_t>>
      queues_;  ///< per station; the first `slots` in reach are served
};

}  // namespace muster::world
