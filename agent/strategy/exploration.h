#pragma once

#include <optional>
#include <vector>

#include "agent/strategy/vantages.h"
#include "common/map/targets.h"
#include "common/robot/knowledge.h"
#include "common/robot/strategy.h"

namespace muster::agent {

/// Exploring one region: what is left to see (Targets), in which order (FF3E, Alg. 1 of S0,
/// receding horizon), until nothing is: first until nothing large is, then in the small. What the
/// feature detector has looked at before counts: for another region, with the box in view, or for
/// this one, earlier, by an earlier start or by somebody else who told.
class Exploration {
 public:
  Exploration(robot::Knowledge& knowledge, RegionId region);

  RegionId region() const { return region_; }
  SimTime since() const { return since_; }
  /// Everything has been looked at; the round of thorough looks follows.
  bool surveyed() const { return surveyed_; }
  bool done() const { return done_; }
  double known_m3(const robot::Knowledge& knowledge) const {
    return knowledge.map().known_m3(watched_);
  }
  double volume_m3(const robot::Knowledge& knowledge) const {
    return knowledge.map().volume_m3(watched_);
  }
  const map::Targets& targets() const { return targets_; }

  void on_scan(const mission::Scan& scan);
  void on_look(const robot::Knowledge& knowledge, const mission::Sightings& sightings);

  /// Where to fly next: the first of FF3E's order, kept until it is reached and seen, or has
  /// nothing left to show. nullopt: nothing is left that can be reached (see done), or nothing is
  /// known of the region yet (then `approach` says where to go). `budget_s`: until the explorer has
  /// to leave for its meeting at `meeting`.
  std::optional<robot::Intent> next(robot::Knowledge& knowledge, const robot::Progress& progress,
                                    double budget_s, const Vec3& meeting,
                                    std::vector<mission::PlanningTime>& planning);

 private:
  struct Goal {
    View view;
    bool cluster = false;  ///< a viewpoint of Targets, not only a place with a view
    bool surface = false;
  };
  void recall(const robot::Knowledge& knowledge);
  void take_told_looks(const robot::Knowledge& knowledge);
  void count_look(const robot::Knowledge& knowledge, const Pose& sensor, double pitch_rad);
  ViewPrice price() const;
  double worth_looking_m2(const robot::Knowledge& knowledge) const;
  bool worth_keeping(const robot::Knowledge& knowledge, const robot::Progress& progress);
  bool used_up() const;
  void refresh(robot::Knowledge& knowledge, bool thorough,
               std::vector<mission::PlanningTime>& planning);
  Goal cluster_goal(robot::Knowledge& knowledge, const map::Viewpoint& v);
  std::vector<Goal> candidates(robot::Knowledge& knowledge);
  std::optional<Goal> leftover(robot::Knowledge& knowledge, double budget_s, const Vec3& meeting);
  bool choose(robot::Knowledge& knowledge, double budget_s, const Vec3& meeting,
              std::vector<mission::PlanningTime>& planning);
  bool barred(const Pose& pose, SimTime now) const;
  robot::Intent fly_to(const Goal& goal) const;

  RegionId region_;
  SimTime since_;
  map::Targets targets_;
  Vantages vantages_;
  std::size_t watched_;
  double look_period_s_;
  std::optional<Goal> goal_;
  std::optional<SimTime> arrived_;
  std::uint64_t scans_ = 0, looks_ = 0;  // heard so far
  std::uint64_t settled_ = 0, refreshed_scans_ = 0, arrived_scans_ = 0, arrived_looks_ = 0,
                arrived_counted_ = 0;
  std::size_t told_looks_ = 0;  // taken in
  SimTime last_look_, refresh_again_, give_up_;
  bool entered_ = false;  // something of the box is known
  bool surveyed_ = false, done_ = false;
  int empty_rounds_ = 0;
  struct Barred {
    Pose pose;
    double off_rad;  // headings within this of the pose's
    SimTime until;
  };
  std::vector<Barred> barred_;  // could not be reached, or did not show what they promised
};

}  // namespace muster::agent
