#pragma once

#include <optional>
#include <vector>

#include "common/robot/knowledge.h"

namespace muster::robot {

/// The agreement of one pair, station and explorer, on when and where to be in contact next (DESIGN
/// "Meetings"; S0 IV-B, S0.6). Both sides derive it from the same two records, the explorer's
/// proposal and the station's acknowledgement of exactly that proposal:
///
///     explorer (proposes):      agreed m ──propose──▶ agreed m, pending m+1
///                                                       │ acknowledgement heard in this contact
///                                                       └──▶ agreed m+1
///     station (acknowledges):   agreed m ──proposal heard in contact, acknowledgement written──▶ agreed m+1
///
/// An acknowledgement that arrives after the contact is void: then the station follows m+1 and the
/// explorer m, and both end on the same
/// **standing rung**, the mission's place and times t0 + j·T. Rungs are tried in order; one whose
/// window has passed was missed. Windows are longer by what one's own clock may be wrong: what is
/// past has to be past on the partner's clock, too.
class Agreement {
 public:
  Agreement(RobotId self, RobotId partner) : self_(self), partner_(partner) {}

  RobotId partner() const { return partner_; }
  /// Number of the last meeting agreed on; 0: none yet.
  std::uint64_t number() const { return number_; }
  bool pending() const { return pending_.has_value(); }

  /// Takes up what this robot's earlier start had agreed on: the acknowledgement names it, whoever
  /// wrote it. To be called in the first tick, before anything new of this start voids what is
  /// kept.
  void resume(const Knowledge& knowledge);
  /// Explorer that kept nothing, once per tick: somebody may know what its earlier start had agreed
  /// on. What was acknowledged to this start is heard by `update`, or void.
  void be_told(const Knowledge& knowledge);
  /// Explorer: proposes the next meeting. Publishes the record.
  void propose(Knowledge& knowledge, std::vector<mission::Rung> ladder, RegionId region);
  /// Once per tick, both sides: takes in what was heard. True in the tick in which a new agreement
  /// was reached.
  bool update(Knowledge& knowledge);
  /// No meeting is wanted any more (explorer released by the station).
  void clear();

  /// Where and when to be next: the first rung whose window has not passed, else the next standing
  /// rung.
  mission::Rung next(const Knowledge& knowledge) const;
  /// Rungs of the present ladder (standing ones included) that have passed without a new agreement.
  int missed(const Knowledge& knowledge) const;

 private:
  bool hear_acknowledgement(Knowledge& knowledge);
  bool acknowledge(Knowledge& knowledge);

  RobotId self_, partner_;
  std::uint64_t number_ = 0;
  SimTime since_;  // when it was agreed
  std::vector<mission::Rung> ladder_;
  struct Pending {
    std::uint64_t number;
    std::vector<mission::Rung> ladder;
  };
  std::optional<Pending> pending_;
  std::pair<std::uint64_t, std::uint64_t>
      acknowledged_{};  // (epoch, seq) of the proposal last acknowledged
};

/// The j-th standing rung is [t0 + j·T, + window]; the first whose end lies after `now`.
mission::Rung standing_rung(const mission::StandingConfig& standing, SimTime now);

}  // namespace muster::robot
