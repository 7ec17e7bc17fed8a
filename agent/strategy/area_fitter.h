#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "common/robot/knowledge.h"

namespace muster::agent {

/// Fits areas of interest from noisy sightings (S0 (4)): sightings within 0.5 m of an area that can
/// be of the same surface belong to it and refine its position; others begin a new one. Its normal
/// is the mean direction to the sighters, in whose hemisphere the surface faces; whoever inspects
/// it asks its own map for more (SurfaceBelief).
///
/// A sighting costs nothing and an area costs an inspector a flight, so what was sighted is held
/// against what is known before it becomes an area:
///
///     sighting ─┬─ a finding within 4 σ whose surface shows itself to the sighter ─▶ explained
///               ├─ nothing was found right there                     ─▶ explained: a false area
///               ├─ no area, finding or answer anywhere near          ─▶ an area at once
///               └─ near one, but not of it                           ─▶ an area when sighted
///                                                again, or when nothing explains it for a while
///
/// One look sights a feature once. So two sightings near each other in one look are two features.
///
/// An inspection answers with the features that satisfied the rule from one pose, and two features
/// may lie within 0.5 m of each other, on two sides of a thin eave, say. So when a result comes in,
/// every sighting of its area is held against it again; what it does not explain begins an area of
/// its own, from the direction in which it was seen, at most twice.
class AreaFitter {
 public:
  /// Only sightings inside `region`'s box (with a margin), or outside every box, are this
  /// explorer's business: what lies in another box is owed by whoever explores that one.
  void take(robot::Knowledge& knowledge, const mission::Sightings& sightings, RegionId region);
  /// Holds the areas whose results came in since the last call against their sightings; cheap when
  /// none did. `explored`: no more looks are to come that could settle a doubt.
  void review(robot::Knowledge& knowledge, bool explored);

 private:
  struct Seen {
    mission::Sighting sighting;
    Vec3 towards;  ///< unit, to the sighter
    Pose sensor;
    std::uint64_t look = 0;  ///< in which one
    int reviews = 0;
  };
  struct Fit {
    std::optional<mission::AreaRef> ref;  ///< none: not an area yet
    std::vector<Seen> seen;
    SimTime since;
    mission::Area area;
    Vec3 published = Vec3::Zero();
    std::uint32_t published_count = 0;
    bool closed = false;  ///< its result is in
    Vec3 mean() const;
    Vec3 towards() const;  ///< sum of unit directions to where it was sighted from
    bool seen_in(std::uint64_t look) const;
  };

  void add(robot::Knowledge& knowledge, const Seen& seen, RegionId region);
  Fit* open_fit(const robot::Knowledge& knowledge, const Seen& seen);
  bool doubtful(const robot::Knowledge& knowledge, const Seen& seen) const;
  bool asked_enough(const Vec3& p) const;
  bool explained(const robot::Knowledge& knowledge, const Seen& seen,
                 std::set<FeatureId>* taken = nullptr) const;
  std::set<FeatureId> claimed_beside(const robot::Knowledge& knowledge, const Seen& seen) const;
  std::vector<Seen> unexplained(const robot::Knowledge& knowledge, const Fit& fit) const;
  void settle_doubts(robot::Knowledge& knowledge, bool explored);
  static Pose squarest(const robot::Knowledge& knowledge, const Fit& fit);
  void publish(robot::Knowledge& knowledge, Fit& fit);

  std::vector<Fit> fits_;
  std::size_t results_ = 0;  // at the last review
  SimTime doubts_again_;
  std::uint64_t looks_ = 0;
  bool explored_ = false;
};

}  // namespace muster::agent
