#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "common/robot/knowledge.h"

namespace muster::agent {

/// An explorer's view of its inspectors (S0 IV-C): where each will be when, what it was given, whom
/// to meet next, and who is lost. Built from what the radio brought: the inspector's own route and
/// the explorer's own allocations.
class Subgroup {
 public:
  struct Mate {
    RobotId id;
    SimTime seen;                  ///< last contact
    SimTime not_before;            ///< of the next visit, after one in vain
    int in_vain = 0;               ///< visits in a row, lost or not
    std::optional<RegionId> told;  ///< the region of the newest allocation that it has heard
    int missed = 0;                ///< meetings in a row at which it was not there; 2: lost (S0.15)
    int out_of_reach = 0;          ///< visits in a row on which no way was found
    bool lost = false;
  };
  struct Visit {
    RobotId mate;
    Vec3 place = Vec3::Zero();
    SimTime at;
  };

  /// Once per tick: who belongs to me by the station's newest assignment, who was heard, which
  /// areas are not given to anybody.
  void update(robot::Knowledge& knowledge, RegionId region);

  /// Shares the areas not given yet among the inspectors, and gives those in contact theirs.
  /// Publishes the allocation record when it changed. `region`: where the group works; kNoRegion:
  /// it is released.
  void allocate(robot::Knowledge& knowledge, RegionId region, bool exploring,
                std::vector<mission::PlanningTime>& planning);

  /// Whom to visit now; nullopt: nobody. While exploring only who would stand idle, and only when
  /// the work to hand over outweighs the way there and back (12); after it whoever holds results or
  /// has not heard the newest allocation, as soon as it is through with its work; and when nobody
  /// is left to go to, but work is, those who are lost, wherever they may wait.
  std::optional<Visit> next_visit(const robot::Knowledge& knowledge, bool exploring) const;
  /// Where `mate` is expected at `t`.
  Vec3 expected_place(const robot::Knowledge& knowledge, RobotId mate, SimTime t) const;
  SimTime free_at(const robot::Knowledge& knowledge, RobotId mate) const;
  /// It was not where it was expected, for the tolerance; or there was no way to there.
  void missed(robot::Knowledge& knowledge, RobotId mate, bool arrived);
  /// Until all areas known so far are inspected and their results collected, about.
  double remaining_s(const robot::Knowledge& knowledge) const;

  /// In contact, has heard the newest allocation, and everything it had is here.
  bool settled(const robot::Knowledge& knowledge, RobotId mate) const;
  /// Every mate that is not lost has heard what concerns it.
  bool all_informed() const;
  std::size_t open_areas() const { return open_.size(); }
  /// Areas of the region whose results are not all here (given or not).
  std::size_t outstanding(const robot::Knowledge& knowledge, RegionId region) const;
  const std::map<RobotId, Mate>& mates() const { return mates_; }

 private:
  std::optional<Visit> search_for_lost(const robot::Knowledge& knowledge) const;
  /// Nothing of what I allocated concerns it that it has not heard.
  bool informed(RobotId mate) const;
  bool mine(const robot::Knowledge& knowledge, const mission::AreaRef& ref, RegionId region) const;
  void publish(robot::Knowledge& knowledge, RegionId region);

  std::map<RobotId, Mate> mates_;
  std::map<mission::AreaRef, RobotId> given_;
  std::set<mission::AreaRef> heard_;     // of given_: the inspector has the allocation
  std::vector<mission::AreaRef> order_;  // of given_, as each inspector shall visit them
  std::vector<mission::AreaRef> open_;
  std::vector<RobotId> published_mates_;
  RegionId published_region_ = kNoRegion;
  bool published_ = false;
};

}  // namespace muster::agent
