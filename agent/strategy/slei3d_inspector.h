#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "agent/strategy/view_poses.h"
#include "common/robot/strategy.h"

namespace muster::agent {

/// The inspector of SLEI3D (S0 IV-C): does what its explorer allocated, in the order given; waits
/// where it ended, so that the explorer, which knows this plan, can come to it; after a while waits
/// at its region's gathering place. Publishes its route for the explorer to plan by.
///
///     areas left ─▶ travel ─▶ look (t_q) ─▶ result published ─┐
///         ▲───────────────────────────────────────────────────┘
///     none left ─▶ wait here (30 s) ─▶ gathering place ─▶ (unheard for long) standing place ─▶
///     home
class Slei3dInspector : public robot::Strategy {
 public:
  robot::Intent decide(robot::Knowledge& knowledge, const robot::Progress& progress) override;
  std::vector<mission::PlanningTime> take_planning() override {
    return std::exchange(planning_, {});
  }

 private:
  struct Orders {
    RobotId leader = kNoRobot;
    RegionId region = kNoRegion;
    bool released = false;
    std::vector<mission::AreaRef> areas;  // in order, not inspected yet as far as known
  };
  Orders orders(const robot::Knowledge& k) const;
  robot::Intent inspect(robot::Knowledge& k, const Orders& orders, const robot::Progress& progress);
  robot::Intent wait(robot::Knowledge& k, const Orders& orders);
  bool choose_pose(robot::Knowledge& k, const mission::AreaRef& ref);
  void give_up_pose(robot::Knowledge& k, bool refused);
  void postpone(robot::Knowledge& k, const mission::AreaRef& ref);
  void report(robot::Knowledge& k, const mission::Inspected& inspected);
  void publish_route(robot::Knowledge& k, const Orders& orders);

  std::vector<mission::PlanningTime> planning_;
  std::optional<mission::AreaRef> current_;
  ViewPose view_;                             // of the current area
  std::map<mission::AreaRef, int> attempts_;  // in vain
  std::map<mission::AreaRef, std::vector<RefusedLook>> refused_;
  std::map<mission::AreaRef, SimTime> not_before_;
  SimTime idle_since_;
  bool worked_ = false;  // had areas since it was given this region
  SimTime look_again_;
  std::vector<mission::AreaRef> routed_;
  bool route_published_ = false;
  RegionId routed_region_ = kNoRegion;
};

/// How long an inspector that ran out of areas waits where it is, before it goes to the gathering
/// place.
inline constexpr double kWaitHere_s = 30;

/// Where the idle inspectors of a region wait: near the box corner that is nearest to the standing
/// place, each a little apart.
Vec3 gathering_place(const mission::Mission& mission, RegionId region, RobotId inspector);

}  // namespace muster::agent
