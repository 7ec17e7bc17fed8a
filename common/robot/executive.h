#pragma once

#include <map>
#include <optional>
#include <vector>

#include "common/mission/messages.h"
#include "common/nav/trajectory.h"
#include "common/robot/knowledge.h"
#include "common/robot/lookout.h"
#include "common/robot/seen_bodies.h"
#include "common/robot/strategy.h"

namespace muster::robot {

/// The flying half of a robot: turns an intent into trajectories that are checked before they are
/// flown and again whenever the map or a teammate's announcement changes, and into inspection
/// requests.
///
///     intent ─▶ path (A*) ─▶ timed trajectory ─▶ checked ─▶ flown ──┬─▶ arrived ─▶ inspect / land
///                  ▲                              │ unsafe          │ unsafe ahead
///                  └───────── wait, go round ◀────┴──── brake ◀─────┘
///
/// Right of way: the smaller (role, id) goes first; the other brakes, goes round, and after a while
/// steps aside. Both brake when it gets close; who follows stays far enough behind to brake when
/// the other does. Bodies seen but not heard (radio off, dead robots) are short-lived obstacles
/// that everybody brakes for. Who stands idle makes room for a neighbour that stands although it is
/// on its way.
class Executive {
 public:
  explicit Executive(const mission::Mission& mission, RobotId self);

  struct Commands {
    std::optional<mission::Trajectory> trajectory;
    std::optional<mission::Inspect> inspect;
  };
  Commands step(Knowledge& knowledge, const Intent& intent);

  /// Before anything else straight up to `to`, the way that the body came down.
  void rise_first(const Vec3& to) { rise_first_ = to; }
  /// The world's answer to an inspection: shown in the next progress.
  void on_inspected(const mission::Inspected& inspected);
  /// To be told what the camera sees.
  SeenBodies& bodies() { return bodies_; }
  Lookout& lookout() { return lookout_; }

  const Progress& progress() const { return progress_; }
  const nav::Trajectory& trajectory() const { return trajectory_; }
  /// Where it will be in the next seconds, for its beacon; empty when it goes nowhere.
  std::vector<mission::TimedPose> announcement(SimTime now) const;

 private:
  void forget_flight(const Knowledge& knowledge);
  void look_around(Knowledge& knowledge);
  void note_standing(SimTime now, const Teammate& mate);
  void note_silence(const Knowledge& knowledge);
  bool waits_for_radio(SimTime now) const;
  void dodge(Knowledge& knowledge, Commands& commands);
  void make_room(Knowledge& knowledge, Commands& commands);
  bool rise(Knowledge& knowledge, Commands& commands);
  bool rise_as_it_came(Knowledge& knowledge, Commands& commands);
  void remember(const Vec3& here);
  bool back_out(Knowledge& knowledge, Commands& commands);
  void no_way(Knowledge& knowledge);
  bool taken(const map::VoxelMap& map, const Vec3& p) const;
  void find_landing(Knowledge& knowledge, const Intent& intent, Commands& commands);
  bool stay_safe(Knowledge& knowledge, Commands& commands);
  std::optional<RobotId> follows_too_closely(const Knowledge& knowledge) const;
  bool may_look_away(const Knowledge& knowledge, const Intent& intent, const nav::Path& path) const;
  void plan(Knowledge& knowledge, const Intent& intent, Commands& commands);
  void plan_transit(Knowledge& knowledge, const Intent& intent, Commands& commands);
  void step_aside(Knowledge& knowledge, Commands& commands);
  bool fly(Knowledge& knowledge, const nav::Path& whole, const Intent& intent, Commands& commands);
  std::vector<map::Sphere> parked(SimTime now) const;
  void set_out(Knowledge& knowledge, nav::Trajectory trajectory, Commands& commands);
  void turn(Knowledge& knowledge, double yaw_rad, Commands& commands);
  void brake(Knowledge& knowledge, Commands& commands);
  void command(Knowledge& knowledge, nav::Trajectory trajectory, Commands& commands);
  void blocked(SimTime now, std::string reason, RobotId by = kNoRobot);
  bool resting(SimTime now) const { return trajectory_.empty() || now >= trajectory_.end(); }
  nav::State state(const Knowledge& knowledge) const;
  bool goes_first(const Knowledge& knowledge, RobotId other) const;

  RobotId self_;
  double radius_m_;
  nav::Limits limits_;
  Progress progress_;
  SimTime stepped_at_;
  Intent intent_;
  nav::Trajectory trajectory_;
  std::uint64_t trajectory_n_ = 0;
  bool plan_due_ = false;
  bool partial_ = false;  // what is flown ends where the known space does
  SimTime plan_again_;
  std::optional<SimTime> blocked_since_;
  RobotId blocked_by_ = kNoRobot;
  std::optional<SimTime> aside_until_;
  std::map<RobotId, SimTime> standing_since_;  // teammates that want to go and stand
  SimTime room_again_;
  std::optional<Vec3> rise_first_;
  std::vector<Vec3> trail_;         // where it has been, the latest last
  std::optional<Vec3> landing_at_;  // instead of a landing place that is taken
  int landing_tries_ = 0;
  bool way_done_ = false;     // the last way found ends here
  bool backing_out_ = false;  // what is flown is the way it came
  int no_way_ = 0;            // searches in a row that found none
  int pressed_ = 0;           // ways in a row that led closer to what is too close

  std::uint64_t checked_revision_ = 0;
  SimTime checked_at_;
  std::vector<nav::Mover> movers_;
  SeenBodies bodies_;
  // Somebody who is near and in sight is not heard, nor anybody else.
  std::optional<SimTime> radio_doubted_since_;
  Lookout lookout_;

  std::vector<std::pair<map::Sphere, SimTime>> avoid_;  // unknown space that led nowhere
  Vec3 transit_from_ = Vec3::Zero();
  int transit_stuck_ = 0;

  std::uint64_t request_n_ = 0;
  bool request_open_ = false;
  bool landing_ = false;
};

}  // namespace muster::robot
