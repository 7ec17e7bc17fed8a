#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "common/core/ids.h"
#include "common/core/time.h"

namespace muster::commsim {

/// Who was in contact with whom, and when: from the first beacon heard, either way, to the last
/// before a silence of more than 1 s.
class Contacts {
 public:
  void beacon_heard(RobotId from, RobotId by, SimTime at);
  /// One entry per pair that ever met, ascending.
  nlohmann::json to_json() const;

 private:
  struct Interval {
    SimTime from, until;
  };
  std::map<std::pair<RobotId, RobotId>, std::vector<Interval>> pairs_;
};

}  // namespace muster::commsim
