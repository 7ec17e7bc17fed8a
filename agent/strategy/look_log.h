#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "agent/strategy/surface_belief.h"
#include "common/robot/knowledge.h"

namespace muster::agent {

/// The cosine between directions so close that both can be of one surface, whatever it is.
inline constexpr double kPlainCos = 0.5;
/// The chance of showing itself to a sighter below which it is another surface that was sighted.
inline constexpr double kOtherSide = 0.08;

/// A result with parts is the camera's answer; one without says that the inspector gave up.
inline bool answered(const mission::Inspection& inspection) { return inspection.parts > 0; }

/// One sighting: the `place`-th of the explorer's `look`-th look.
struct Seen {
  mission::Sighting sighting;
  Vec3 towards;  ///< unit, to the sighter
  Pose sensor;
  std::size_t look = 0, place = 0;
  int reviews = 0;  ///< areas that were asked for because of it, and brought something else
};

/// All looks of one explorer, and which of their sightings are explained by what inspections found.
///
/// A feature is sighted once in a look, and one inspected explains one sighting of it at most, the
/// nearest: so of two sightings beside one known feature, one is of something else. Where an
/// inspection found nothing there is nothing for 0.5 m around, and every sighting there is of a
/// false area.
class LookLog {
 public:
  /// Takes in a look; returns those of its sightings that nothing explains.
  std::vector<Seen> take(const robot::Knowledge& knowledge, const Pose& sensor,
                         const std::vector<mission::Sighting>& seen);
  /// Holds the looks against results that came in since the last call; false when none did.
  bool renew(const robot::Knowledge& knowledge);
  bool explained(const Seen& seen) const;
  /// Sightings that one feature explained each for itself, and that all together are more likely of
  /// another one beside it. From now on that feature does not explain them.
  std::vector<Seen> second_features(double sigma_m);

 private:
  enum class Source : std::uint8_t { kUnknown, kNothing, kFeature };
  struct Entry {
    mission::Sighting sighting;
    Source source = Source::kUnknown;
    FeatureId feature{};                  ///< of kFeature
    std::optional<FeatureId> other_than;  ///< told apart from it
  };
  struct Look {
    Pose sensor;
    std::vector<Entry> seen;
  };
  struct Feature {
    Vec3 position = Vec3::Zero();
    std::vector<Vec3> from;  ///< units, towards who inspected it
    std::optional<SurfaceBelief> belief;
    std::size_t tested = 0;  ///< sightings that were found to be of one feature
  };
  Seen seen(std::size_t look, std::size_t place) const;
  void explain(const robot::Knowledge& knowledge, Look& look);
  static double shows(const robot::Knowledge& knowledge, Feature& feature, const Vec3& towards);

  std::vector<Look> looks_;
  std::map<FeatureId, Feature> features_;
  std::vector<Vec3> nothing_;  ///< where inspections found nothing
  std::set<mission::AreaRef> taken_in_;
};

/// What is known of the surface at `p` that was seen from unit direction `towards`.
SurfaceBelief belief_at(const robot::Knowledge& knowledge, const Vec3& p, const Vec3& towards,
                        double sigma_m);

/// Which of `points`, each `sigma_m` per axis off its source, belong to a second source: beside the
/// one at `first`, or, without it, beside where one source for all would be. Empty when one is as
/// likely. (The likelihood of the better of two sources each, against that of one, by more than
/// what a split of noise gains.)
std::vector<std::size_t> second_source(const std::vector<Vec3>& points, double sigma_m,
                                       const std::optional<Vec3>& first);

}  // namespace muster::agent
