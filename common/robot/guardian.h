#pragma once

#include <optional>

#include "common/robot/knowledge.h"
#include "common/robot/strategy.h"

namespace muster::robot {

/// What no strategy may overrule (DESIGN "Safety and the end"): the operator's requests, obeyed in
/// the tick in which they are heard; the battery reserve; the lost-contact limit. Fence and ceiling
/// are the map's bounds: nothing outside is ever traversable.
///
///     resume ◀── hold: stay where it is      return: home, hover      land: here      abort: home
///     and land battery below reserve, or nobody heard for the mission's lost_contact_s: in
///     turns, home and land
class Guardian {
 public:
  /// The intent to follow instead of the strategy's, when there is one.
  std::optional<Intent> overrule(const Knowledge& knowledge);

 private:
  std::optional<Vec3> land_here_;
  bool going_silently_ = false;  // nobody was heard for too long, and its turn has come
};

/// To the start, and land there.
Intent go_home(const Knowledge& knowledge, std::string reason, bool land = true);

}  // namespace muster::robot
