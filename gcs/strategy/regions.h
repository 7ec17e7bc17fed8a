#pragma once

#include <map>
#include <optional>
#include <vector>

#include "common/robot/knowledge.h"

namespace muster::gcs {

/// The life of the bounding boxes (S0.4) and who works on them:
///
///     pending → assigned → explored → surveyed → assigned → explored → done
///
/// Rolling assignment (S0.11): at first every explorer gets the nearest box and inspectors by
/// volume (14); later a group whose box is surveyed, with all its results here, gets the nearest
/// pending one. None left: the nearest of those that it surveyed, or else of all that were, for the
/// thorough round. None of these: it is released, until there is something to do after all: an area
/// that was told of late, a box whose explorer was lost. So what is easily found of the whole site
/// is delivered before anybody looks for the rest.
class Regions {
 public:
  explicit Regions(const mission::Mission& mission);

  struct Group {
    RobotId explorer;
    RegionId region = kNoRegion;
    std::vector<RobotId> inspectors;
    bool released = false;
    bool lost = false;
    RegionId held = kNoRegion;  ///< while lost: what it was working on
  };

  /// At the start: everybody gets something. A station that starts again and kept nothing leaves
  /// everybody with what they say they work on, as far as it has heard. Publishes the assignment
  /// record.
  void assign_all(robot::Knowledge& knowledge);
  /// After a restart: takes up the assignment that an earlier start had published. False when there
  /// is none.
  bool resume(robot::Knowledge& knowledge);
  /// `explorer` is here and says how far it is. Gives it the next region when its own is done, and
  /// inspectors of the largest group when it has none. True when the assignment changed.
  bool report(robot::Knowledge& knowledge, RobotId explorer);
  /// `explorer` was not seen at its standing rung: its box is pending again, its inspectors go to
  /// whoever comes next (S0.16); to itself, should it come after all.
  void lost(robot::Knowledge& knowledge, RobotId explorer);

  const std::map<RobotId, Group>& groups() const { return groups_; }
  bool all_done() const;
  mission::RegionState state(RegionId region) const { return regions_[region.value].state; }

 private:
  void leave_at_work(const robot::Knowledge& knowledge);
  bool reopen(const robot::Knowledge& knowledge);
  void give(Group& group, const Vec3& from, const robot::Knowledge& knowledge);
  void back(robot::Knowledge& knowledge, Group& group);
  bool reinforce(const robot::Knowledge& knowledge, Group& group);
  std::optional<RegionId> next_for(RobotId explorer, const Vec3& from,
                                   const robot::Knowledge& knowledge) const;
  void publish(robot::Knowledge& knowledge) const;

  struct Region {
    mission::RegionState state = mission::RegionState::kPending;
    RobotId surveyor = kNoRobot;
  };
  std::vector<Region> regions_;
  std::map<RobotId, Group> groups_;
  std::vector<RobotId> orphans_;
};

}  // namespace muster::gcs
