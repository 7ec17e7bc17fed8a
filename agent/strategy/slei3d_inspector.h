#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "agent/strategy/view_poses.h"
#include "common/robot/strategy.h"

namespace muster::agent {

/// The inspector of SLEI3D (S0 IV-C): does what its explorer allocated, in the order given; then
/// waits where its route says that it ends. The explorer heard that route when it gave the work, so
/// it knows where to come to; nothing is announced that it cannot have heard.
///
///     areas left ─▶ travel ─▶ look (t_q) ─▶ result published ─┐
///         ▲───────────────────────────────────────────────────┘
///     none left ─▶ the announced end of the route (before any work: the gathering place)
///               ─▶ (unheard for long) where it started ─▶ home
class Slei3dInspector : public robot::Strategy {
 public:
  robot::Intent decide(robot::Knowledge& knowledge, const robot::Progress& progress) override;

 private:
  struct Orders {
    RobotId leader = kNoRobot;
    RegionId region = kNoRegion;
    bool released = false;
    std::vector<mission::AreaRef> areas;  // in order, not inspected yet as far as known
  };
  Orders orders(const robot::Knowledge& knowledge) const;
  robot::Intent inspect(robot::Knowledge& knowledge, const Orders& orders,
                        const robot::Progress& progress);
  robot::Intent wait(robot::Knowledge& knowledge, const Orders& orders);
  bool choose_pose(robot::Knowledge& knowledge, const mission::AreaRef& ref);
  void next_area(robot::Knowledge& knowledge, std::vector<mission::AreaRef> areas);
  void give_up_pose(robot::Knowledge& knowledge, bool refused);
  void postpone(robot::Knowledge& knowledge, const mission::AreaRef& ref);
  static std::vector<VainLook> looks_of_others(const robot::Knowledge& knowledge,
                                               const mission::AreaRef& ref);
  static bool sure(const robot::Knowledge& knowledge, const mission::AreaRef& ref);
  static bool given_up_before(const robot::Knowledge& knowledge, const mission::AreaRef& ref);
  bool may_be_stray(const robot::Knowledge& knowledge, const mission::AreaRef& ref);
  static bool explored(const robot::Knowledge& knowledge, const mission::AreaRef& ref);
  void report_nothing(robot::Knowledge& knowledge, const mission::AreaRef& ref);
  void report(robot::Knowledge& knowledge, const mission::Inspected& inspected);
  void publish_route(robot::Knowledge& knowledge, const Orders& orders);
  Vec3 route_end(robot::Knowledge& knowledge, const Orders& orders) const;

  std::optional<mission::AreaRef> current_;
  ViewPose view_;              // of the current area
  Vec3 asked_ = Vec3::Zero();  // the spot that the camera is asked about
  /// What one area has cost so far.
  struct Effort {
    std::vector<VainLook> in_vain;
    int looks = 0;       ///< refused
    int tries = 0;       ///< to find a pose or to get there, without a look
    int rounds = 0;      ///< of all the tries there are
    double open = 1;     ///< chance that refusals beside a known feature missed another one
    SimTime not_before;  ///< of the next try
  };
  std::map<mission::AreaRef, Effort> efforts_;
  bool open_when_chosen_ = false;  // nothing stood between the pose and the area
  std::optional<SimTime> looking_since_;
  Vec3 moved_to_ = Vec3::Zero();  // on the way to the current pose
  SimTime moved_at_;
  bool worked_ = false;      // had areas since it was given this region
  std::optional<Vec3> end_;  // of the announced route
  SimTime look_again_;
  std::vector<mission::AreaRef> routed_;
  bool route_published_ = false;
  SimTime routed_at_;
  RegionId routed_region_ = kNoRegion;
};

/// How long an inspector that does not hear its explorer waits where it was expected, before it
/// goes back to where it started. The explorer counts the same time.
inline constexpr double kUnheard_s = 400;

/// Where the inspectors of a region wait before they are given anything: near the box corner that
/// is nearest to the standing place, each a little apart.
Vec3 gathering_place(const mission::Mission& mission, RegionId region, RobotId inspector);

}  // namespace muster::agent
