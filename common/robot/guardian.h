#pragma once

#include <optional>
#include <set>

#include "common/robot/knowledge.h"
#include "common/robot/strategy.h"

namespace muster::robot {

/// What no strategy may overrule (DESIGN "Safety and the end"): the operator's requests, obeyed in
/// the tick in which they are heard; the battery reserve; the lost-contact limit. Fence and ceiling
/// are the map's bounds: nothing outside is ever traversable.
///
///     hold                  stay where it is, until `resume`
///     return                home, and hover there
///     land                  here
///     abort                 home, and land
///     battery below reserve, or nobody heard for the mission's lost_contact_s:  home, and land
///
/// Who is called home together with everybody does not leave the others waiting where nothing is
/// heard: the station, which has just seen where its explorers fly, and an explorer, which knows
/// its inspectors' routes, tell those near their way first, for three minutes at most.
class Guardian {
 public:
  /// The intent to follow instead of the strategy's, when there is one.
  std::optional<Intent> overrule(const Knowledge& knowledge);

 private:
  struct Errand {
    RobotId mate;
    Vec3 place;
    SimTime until;
    bool last = true;  // the last place to look for it
  };
  std::optional<Intent> tell_others(const Knowledge& knowledge);
  static std::optional<mission::TimedPose> expected(const Knowledge& knowledge,
                                                    const Teammate& mate, bool late);
  std::optional<Errand> next_errand(const Knowledge& knowledge) const;

  std::optional<Vec3> land_here_;
  std::optional<SimTime> called_home_;  // with everybody
  std::set<RobotId> told_;              // of that, or not to be found
  std::set<RobotId> in_vain_;           // once not where they were expected
  std::optional<Errand> errand_;
  bool going_silently_ = false;  // nobody was heard for too long, and its turn has come
};

/// To the start, and land there.
Intent go_home(const Knowledge& knowledge, std::string reason, bool land = true);

}  // namespace muster::robot
