#pragma once

#include <optional>

#include "agent/strategy/area_fitter.h"
#include "agent/strategy/exploration.h"
#include "agent/strategy/subgroup.h"
#include "common/robot/agreement.h"
#include "common/robot/strategy.h"

namespace muster::agent {

/// The explorer of SLEI3D (S0 IV-B, IV-C). What it does now is the first of these that applies:
///
/// - meet the station: it is time to leave for the agreed place, or the station is here for the
///   meeting (outranks the rest, S0.12);
/// - visit an inspector: it would stand idle and there are areas to give; after exploring: it holds
///   results;
/// - explore: frontiers and surfaces owed looks, in FF3E's order;
/// - wait for its meeting.
///
/// A region is explored in two rounds: first it is surveyed; thorough looks follow when the station
/// says that all regions have been, and until then while it waits for its meeting.
///
/// Who was started again without its journal knows of no region and no meeting. Somebody who passes
/// may tell it; else it finds the station where everybody does who has no agreement, at the
/// standing place.
///
/// A meeting with the station: tell how far the region is; when it is done wait for the next one;
/// propose when and where to meet again (predictor (9), box corner S0.8); leave when that is
/// acknowledged and all records have passed.
class Slei3dExplorer : public robot::Strategy {
 public:
  explicit Slei3dExplorer(const mission::Mission& mission, RobotId self);

  void on_sightings(robot::Knowledge& knowledge, const mission::Sightings& sightings) override;
  void on_scan(robot::Knowledge& knowledge, const mission::Scan& scan) override;
  robot::Intent decide(robot::Knowledge& knowledge, const robot::Progress& progress) override;

 private:
  struct Orders {
    bool known = false;
    RegionId region = kNoRegion;
    bool thorough = false;  ///< all regions have been surveyed: the rest of this one
  };
  Orders orders(const robot::Knowledge& knowledge) const;
  void follow(robot::Knowledge& knowledge, const Orders& orders);

  std::optional<robot::Intent> meet_station(robot::Knowledge& knowledge,
                                            const robot::Progress& progress);
  robot::Intent await_orders(const robot::Knowledge& knowledge) const;
  robot::Intent go_to(const robot::Knowledge& knowledge, const mission::Rung& rung) const;
  double unheard_s(const robot::Knowledge& knowledge) const;
  robot::Intent negotiate(robot::Knowledge& knowledge);
  bool time_to_leave(robot::Knowledge& knowledge, const mission::Rung& rung);
  std::vector<mission::Rung> next_ladder(robot::Knowledge& knowledge);
  Vec3 meeting_corner(robot::Knowledge& knowledge, double in_s);
  void tell_progress(robot::Knowledge& knowledge);
  void tell_looks(robot::Knowledge& knowledge);
  /// As far as was asked for.
  bool explored() const;
  /// Has a region, of which not all is explored.
  bool exploring() const { return exploration_ && !explored(); }
  bool region_done(const robot::Knowledge& knowledge) const;

  std::optional<robot::Intent> visit(robot::Knowledge& knowledge, const robot::Progress& progress);
  bool stayed_in_vain(const robot::Knowledge& knowledge);
  std::optional<robot::Intent> say_farewell(robot::Knowledge& knowledge,
                                            const robot::Progress& progress);

  RobotId station_;
  robot::Agreement agreement_;
  AreaFitter fitter_;
  Subgroup subgroup_;
  std::optional<Exploration> exploration_;
  bool thorough_ = false;
  bool released_ = false;

  // meeting the station
  bool leaving_ = false;  // on the way to, or at, the agreed place
  bool negotiating_ = false;
  SimTime negotiating_since_;
  bool agreed_here_ = false;
  SimTime check_leave_;
  mission::Status told_;
  SimTime told_at_;
  std::size_t told_looks_ = 0;

  // visiting
  std::optional<Subgroup::Visit> visit_;
  std::optional<SimTime> visit_waiting_since_, visit_contact_since_;
  SimTime consider_visit_;
  std::optional<SimTime> staying_since_;  // with one that is still at work
  std::size_t left_when_staying_ = 0;     // areas without a result
  SimTime look_on_until_;
};

}  // namespace muster::agent
