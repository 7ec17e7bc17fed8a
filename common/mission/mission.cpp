#include "common/mission/mission.h"

#include <algorithm>

#include "common/core/error.h"

namespace muster::mission {

const std::vector<std::string>& strategies() {
  static const std::vector<std::string> names{"slei3d"};
  return names;
}

const RobotConfig& Mission::robot(RobotId id) const {
  const auto it =
      std::find_if(fleet.begin(), fleet.end(), [id](const RobotConfig& r) { return r.id == id; });
  MUSTER_CHECK(it != fleet.end());
  return *it;
}

bool Mission::has(RobotId id) const {
  return std::any_of(fleet.begin(), fleet.end(), [id](const RobotConfig& r) { return r.id == id; });
}

std::vector<RobotId> Mission::with_role(Role role) const {
  std::vector<RobotId> ids;
  for (const RobotConfig& r : fleet) {
    if (r.role == role) ids.push_back(r.id);
  }
  return ids;
}

RobotId Mission::station() const {
  const std::vector<RobotId> stations = with_role(Role::kStation);
  MUSTER_CHECK(!stations.empty());
  return stations.front();
}

}  // namespace muster::mission
