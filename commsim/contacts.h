#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "common/core/ids.h"
#include "common/core/time.h"
#include "common/mission/messages.h"

namespace muster::commsim {

/// Who was in contact with whom, and when: from the first beacon heard, either way, to the last
/// before a silence of more than 1 s. And what the two heard of each other, whoever else heard it.
class Contacts {
 public:
  using Pair = std::pair<RobotId, RobotId>;  ///< the smaller one first

  void heard(RobotId from, RobotId by, const mission::Message& message, SimTime at);
  /// Who met since this was last asked: contacts that began after more than 30 s apart, and first
  /// ones. Robots that lose sight of each other for a moment have not met anew.
  std::vector<Pair> take_meetings();
  /// One entry per pair that ever met, ascending.
  nlohmann::json to_json() const;

 private:
  struct Interval {
    SimTime from, until;
  };
  struct Known {
    std::vector<Interval> intervals;
    std::uint64_t meetings = 0, bytes = 0, map_bytes = 0;
    std::uint64_t data_ticks = 0;  // in which a record came through
    SimTime data_at{-1};
  };
  bool begins(Known& known, SimTime at);

  std::map<Pair, Known> pairs_;
  std::vector<Pair> met_;
};

}  // namespace muster::commsim
