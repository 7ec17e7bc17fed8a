#pragma once

#include <cstdint>
#include <vector>

#include "common/robot/knowledge.h"

namespace muster::agent {

/// Fits areas of interest from noisy sightings (S0 (4)): sightings within 0.5 m of an area, from
/// the same side, belong to it and refine its position; others begin a new one. Its normal is the
/// mean direction to the sighters, in whose hemisphere the surface faces; whoever inspects it asks
/// its own map for more (SurfaceBelief).
///
/// An inspection answers with the features that satisfied the rule from one pose, and two features
/// may lie within 0.5 m of each other, on two sides of a thin eave, say. So when a result comes in,
/// every sighting of its area is held against what was found: one that no finding explains begins
/// an area of its own (at most twice), from the direction in which it was seen.
///
///     sighting ─▶ open area ─▶ inspected ─┬─ a finding is near, and was looked at from this side
///     ─▶ explained
///         ▲                               ├─ nothing there at all ─▶ explained: a false area
///         └──────── a new area ◀──────────┘  else
class AreaFitter {
 public:
  /// Only sightings inside `region`'s box (with a margin), or outside every box, are this
  /// explorer's business: what lies in another box is owed by whoever explores that one.
  void take(robot::Knowledge& knowledge, const mission::Sightings& sightings, RegionId region);
  /// Holds the areas whose results came in since the last call against their sightings. Cheap when
  /// none did.
  void review(robot::Knowledge& knowledge);

 private:
  struct Seen {
    mission::Sighting sighting;
    Vec3 towards;  ///< unit, to the sighter
    Pose sensor;
    int reviews = 0;
  };
  struct Fit {
    mission::AreaRef ref;
    std::vector<Seen> seen;
    Vec3 sum = Vec3::Zero();
    Vec3 towards = Vec3::Zero();  ///< sum of unit directions to where it was sighted from
    std::uint32_t published_count = 0;
    mission::Area area;
    Vec3 published = Vec3::Zero();
    bool closed = false;  ///< its result is in
    Vec3 mean() const { return sum / static_cast<double>(seen.size()); }
  };
  void add(robot::Knowledge& knowledge, const Seen& seen, RegionId region);
  Fit* open_fit(const Seen& seen);
  bool explained(const robot::Knowledge& knowledge, const Seen& seen) const;
  void publish(robot::Knowledge& knowledge, Fit& fit);

  std::vector<Fit> fits_;
  std::size_t results_ = 0;  // at the last review
};

}  // namespace muster::agent
