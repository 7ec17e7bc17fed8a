#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "agent/strategy/look_log.h"
#include "common/robot/knowledge.h"

namespace muster::agent {

/// Fits areas of interest from noisy sightings (S0 (4)): sightings near an area that can be of the
/// same surface belong to it and refine its position; others begin a new one. Its normal is the
/// mean direction to the sighters, in whose hemisphere the surface faces; whoever inspects it asks
/// its own map for more (SurfaceBelief).
///
/// A sighting costs nothing and an area costs an inspector a flight, so what was sighted is held
/// against what is known (LookLog) before it becomes an area:
///
///     sighting ─┬─ one of a feature that was found, or of a false area ───▶ explained
///               ├─ no area, finding or answer anywhere near             ──▶ an area at once
///               └─ near one, but not of it                              ──▶ an area when sighted
///                                            again, or when nothing explains it for a while
///
/// An inspection answers with the features that satisfied the rule from one pose, and two features
/// may lie within 0.5 m of each other, on two sides of a thin eave, say. So when a result comes in,
/// every sighting of its area is held against it again; what it does not explain begins an area of
/// its own, from the direction in which it was seen, at most twice. Sightings that fit two sources
/// better than one are shared out between two areas. An area that waits for its inspector says how
/// many of its sightings no result of another explains.
class AreaFitter {
 public:
  /// Sightings inside `region`'s box (with a margin), or outside every box, are this explorer's
  /// business. What lies in another box is owed by whoever explores that one: such a sighting is
  /// kept in mind, and becomes an area only when `region` is explored and nothing has explained it.
  void take(robot::Knowledge& knowledge, const mission::Sightings& sightings, RegionId region);
  /// Holds the areas whose results came in since the last call against their sightings; cheap when
  /// none did. `explored`: no more looks are to come that could settle a doubt.
  void review(robot::Knowledge& knowledge, bool explored);
  /// Something was sighted that may become an area yet.
  bool in_doubt() const;
  /// Before all else, by who starts again: what the looks of earlier starts sighted belongs to the
  /// areas that they began, is explained by results, or is in doubt again. Nothing is asked twice.
  void recall(robot::Knowledge& knowledge);

 private:
  struct Fit {
    std::optional<mission::AreaRef> ref;  ///< none: not an area yet
    std::vector<Seen> seen;               ///< empty only while `recall` is at work
    SimTime since;
    mission::Area area;
    Vec3 published = Vec3::Zero();          ///< position
    std::uint32_t published_sightings = 0;  ///< that this position is the mean of
    std::size_t tested = 0;                 ///< sightings that were found to be of one source
    bool closed = false;                    ///< its result is in
    Vec3 mean() const;
    Vec3 towards() const;  ///< sum of unit directions to where it was sighted from
    bool seen_in(std::size_t look) const;
  };

  std::vector<Seen> news(const robot::Knowledge& knowledge, const mission::Sightings& sightings);
  void add(robot::Knowledge& knowledge, const Seen& seen, RegionId region);
  Fit& begin(const robot::Knowledge& knowledge, const Seen& seen, RegionId region);
  Fit* open_fit(const robot::Knowledge& knowledge, const Seen& seen);
  bool doubtful(const robot::Knowledge& knowledge, const Seen& seen) const;
  bool asked_enough(const robot::Knowledge& knowledge, const Vec3& p) const;
  bool has_fit(const mission::AreaRef& ref) const;
  bool taken_up(const robot::Knowledge& knowledge, const Vec3& p) const;
  bool concerns_us(const robot::Knowledge& knowledge, const Fit& fit) const;
  std::vector<Seen> unexplained(const robot::Knowledge& knowledge, const Fit& fit) const;
  void count_unexplained(robot::Knowledge& knowledge, Fit& fit) const;
  void tell_apart(robot::Knowledge& knowledge);
  void settle_doubts(robot::Knowledge& knowledge, bool explored);
  static Pose squarest(const robot::Knowledge& knowledge, const Fit& fit);
  void publish(robot::Knowledge& knowledge, Fit& fit);

  LookLog log_;
  std::vector<Fit> fits_;
  RegionId region_ = kNoRegion;  ///< of the last sightings
  SimTime doubts_again_;
  bool explored_ = false;
};

}  // namespace muster::agent
