#pragma once

#include <optional>
#include <vector>

#include "common/map/targets.h"
#include "common/robot/knowledge.h"
#include "common/robot/strategy.h"

namespace muster::agent {

/// Exploring one region: what is left to see (Targets), in which order (FF3E, Alg. 1 of S0,
/// receding horizon), until nothing is.
class Exploration {
 public:
  Exploration(robot::Knowledge& knowledge, RegionId region);

  RegionId region() const { return region_; }
  SimTime since() const { return since_; }
  bool done() const { return done_; }
  double known_m3(const robot::Knowledge& knowledge) const {
    return knowledge.map().known_m3(watched_);
  }
  double volume_m3(const robot::Knowledge& knowledge) const {
    return knowledge.map().volume_m3(watched_);
  }
  const map::Targets& targets() const { return targets_; }

  void on_scan(robot::Knowledge& knowledge, const mission::Scan& scan);
  void on_look(const mission::Sightings& sightings) {
    targets_.looked(sightings.sensor, sightings.pitch_rad);
  }

  /// Where to fly next: the first of FF3E's order, kept until it is reached and seen, or has
  /// nothing left to show. nullopt: nothing is left that can be reached (see done), or nothing is
  /// known of the region yet (then `approach` says where to go). `budget_s`: until the explorer has
  /// to leave for its meeting at `meeting`.
  std::optional<robot::Intent> next(robot::Knowledge& knowledge, const robot::Progress& progress,
                                    double budget_s, const Vec3& meeting,
                                    std::vector<mission::PlanningTime>& planning);

 private:
  bool worth_keeping(const robot::Knowledge& k, const robot::Progress& progress);
  void refresh(robot::Knowledge& k, bool thorough, std::vector<mission::PlanningTime>& planning);
  bool choose(robot::Knowledge& k, double budget_s, const Vec3& meeting,
              std::vector<mission::PlanningTime>& planning);
  bool barred(const Vec3& p, SimTime now) const;
  robot::Intent fly_to(const map::Viewpoint& v) const;

  RegionId region_;
  SimTime since_;
  map::Targets targets_;
  std::size_t watched_;
  std::optional<map::Viewpoint> goal_;
  std::optional<SimTime> arrived_;
  std::uint64_t scans_ = 0, refreshed_scans_ = 0, arrived_scans_ = 0;
  SimTime decide_again_;
  bool thorough_ = false;
  bool entered_ = false;  // something of the box is known
  bool done_ = false;
  int empty_rounds_ = 0;
  std::vector<std::pair<Vec3, SimTime>>
      barred_;  // viewpoints that could not be reached, until when
};

}  // namespace muster::agent
