#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/pose.h"
#include "common/mission/mission.h"

namespace muster::world {

struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3i> triangles;
};

struct Hit {
  double distance_m = 0;
  Vec3 normal = Vec3::Zero();  ///< unit, towards the ray's origin
  bool from_behind =
      false;  ///< met on the side that the triangle's winding calls its back: inside a solid
};

/// The place: a triangle mesh that can be asked what a ray meets and how near a point is to a
/// surface. Immutable, so any number of threads may ask. Only world, radio and referee ever see
/// one.
class Scene {
 public:
  /// STL, OBJ, PLY, DAE, glTF (Assimp) or YAML (generators, see deploy/scenes/README.md). Throws
  /// BadInput for a missing, cut-short or empty file and for vertices that are not finite.
  static std::shared_ptr<const Scene> load(const std::string& path);
  /// The mission's scene, with the ground z = 0 under its hull when it says `ground: true`.
  static std::shared_ptr<const Scene> load(const mission::Mission& mission);
  explicit Scene(Mesh mesh);
  ~Scene();

  const Mesh& mesh() const;
  /// First surface along the ray within `max_m`, from either side of it.
  std::optional<Hit> cast(const Vec3& origin, const Vec3& unit_direction, double max_m) const;
  /// Nothing between a and b. A surface within 1 cm of either end does not count, so a point on a
  /// surface is seen from in front of it. The same for (a, b) and (b, a), to the bit.
  bool line_of_sight(const Vec3& a, const Vec3& b) const;
  /// Distance to the nearest surface, at most `cap_m`.
  double clearance(const Vec3& p, double cap_m) const;
  Vec3 low() const;
  Vec3 high() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What a camera looks at when it looks at a spot of a surface: just in front of it, so that the
/// surface itself does not hide it.
inline Vec3 before_surface(const Vec3& spot, const Vec3& normal) { return spot + 0.01 * normal; }

struct Feature {
  FeatureId id;
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
  std::uint32_t type = 0, priority = 0;
  bool real = true;  ///< false: a spot that looks like one (RULES "Sighting and inspecting")
};

struct FeatureSet {
  std::vector<Feature> features;          ///< the true ones, ids 0 … count−1
  std::vector<Feature> decoys;            ///< false areas
  std::uint32_t drawn = 0, rejected = 0;  ///< for `muster scene info`
};

class ReachableSpace;

/// Draws features by the rule of RULES.md ("Features, in every scene"): redrawn until inspectable
/// and sightable from places reachable from the starts. Deterministic per mission seed. Throws
/// BadInput when the scene has too few such places.
FeatureSet draw_features(const Scene& scene, const mission::Mission& mission,
                         const ReachableSpace& reachable);
FeatureSet draw_features(const Scene& scene, const mission::Mission& mission);

}  // namespace muster::world
