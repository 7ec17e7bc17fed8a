#pragma once

#include <vector>

#include "common/robot/knowledge.h"

namespace muster::agent {

/// Fits areas of interest from noisy sightings (S0 (4)): sightings within 0.5 m of an area belong
/// to it and refine its position; others begin a new one. Publishes area records; an area is
/// published again only when its estimate moved or improved noticeably before it was inspected. Its
/// normal is the mean direction to the sighters, in whose hemisphere the surface faces; whoever
/// inspects it asks its own map for more (SurfaceBelief).
class AreaFitter {
 public:
  /// Only sightings inside `region`'s box (with a margin), or outside every box, are this
  /// explorer's business: what lies in another box is owed by whoever explores that one.
  void take(robot::Knowledge& knowledge, const mission::Sightings& sightings, RegionId region);
  /// Areas begun since the last call.
  std::uint32_t take_new() { return std::exchange(new_, 0); }

 private:
  struct Fit {
    mission::AreaRef ref;
    Vec3 sum = Vec3::Zero();
    Vec3 towards = Vec3::Zero();  ///< sum of unit directions to where it was sighted from
    std::uint32_t count = 0;
    std::uint32_t published_count = 0;
    mission::Area area;
    Vec3 published = Vec3::Zero();
    Vec3 mean() const { return sum / count; }
  };
  void publish(robot::Knowledge& knowledge, Fit& fit);

  std::vector<Fit> fits_;
  std::uint32_t new_ = 0;
};

}  // namespace muster::agent
