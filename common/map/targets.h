#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "common/map/voxel_map.h"

namespace muster::map {

/// A pose worth flying to, and what the camera would newly see from there.
struct Viewpoint {
  Pose pose;
  double gain = 0;       ///< in view: frontier area (m²), or what looks at surfaces promise (m²)
  bool surface = false;  ///< false: a frontier; true: surface that the feature detector has not
                         ///< looked at often enough
  std::uint32_t cluster = 0;
};

/// What the camera would newly show from a pose, as far as the map can tell.
struct Worth {
  double unknown_m3 = 0;  ///< unknown volume of the box, if what is unknown were nearly empty
  double owed_m2 = 0;     ///< what one look at surfaces from there promises (RegionCells)
};

/// The worth of every heading at one spot.
struct Panorama {
  static constexpr int kHeadings = 24;
  std::array<Worth, kHeadings> headings;
  /// Middle of the view at heading `i`.
  static double yaw_rad(int i) { return (i - 0.5) * 2 * std::numbers::pi / kHeadings; }
};

struct Refused {
  Vec3 centroid = Vec3::Zero();
  double area_m2 = 0;
  std::string reason;  ///< "no reachable pose sees it", "smaller than 0.50 m²", …
};

struct TargetConfig {
  FieldOfView camera;
  double pitch_rad = 0;
  double min_cluster_m2 = 0.5;
  double max_cluster_extent_m = 2.5;
  /// How often every surface voxel must have been in view of the detector at a look.
  std::uint32_t looks = 2;
  double look_range_m = 4.5;  ///< within the sighting range, with a margin
};

/// What is left to see in one region: frontiers (known-free voxels next to unknown ones, both
/// inside the box), clustered, with viewpoints that see them (range, field of view, occlusion
/// through the map); and surface voxels that were in view at too few looks of the feature detector.
/// Incremental: `update` costs what changed, not the map.
///
/// A viewpoint is a traversable voxel; whether it can be *reached* is the caller's knowledge:
/// `update` is given a predicate.
class Targets {
 public:
  Targets(const VoxelMap& map, const Box& box, const TargetConfig& config);
  ~Targets();

  /// The feature detector looked from here (every Sightings message, also when it saw nothing).
  void looked(const Pose& sensor, double pitch_rad);

  /// A scan taken from here has been integrated into the map: what it should have made known and
  /// did not is given up after a few times.
  void scanned(const Pose& sensor);

  /// Brings clusters and viewpoints up to date with the map. `reachable(p)`: the body can get to p
  /// (cheap; called for candidates only).
  void update(const std::function<bool(const Vec3&)>& reachable);

  /// What looks at a cluster of surface voxels must promise, in area that nobody looked at (0.12 m²
  /// at first), and whether corners below overhangs are to be looked at from several sectors (at
  /// first they are).
  void ask_for(double promise_m2, bool nooks);

  /// Takes in what the last scans and looks changed, without clusters and viewpoints: enough for
  /// `panorama` and `worth`, and far cheaper than `update`.
  void settle();
  /// What is left to see from a spot, in every direction; at one heading. As of the last `settle`
  /// or `update`.
  Panorama panorama(const Vec3& eye) const;
  Worth worth(const Pose& pose) const;

  /// The best viewpoint(s) of every cluster, frontier and surface, ordered by cluster.
  const std::vector<Viewpoint>& viewpoints() const;
  /// Clusters without a viewpoint, with the reason: they no longer keep the region from being
  /// explored (RULES "When things are done").
  const std::vector<Refused>& refused() const;
  /// False while nothing of the box is known. Then: nothing left: no frontier cluster ≥
  /// min_cluster_m2 that a reachable pose sees, and no surface owed looks that a reachable pose
  /// gives.
  bool done() const;
  double frontier_m2() const;
  double owed_surface_m2() const;
  /// Surface found so far.
  double surface_m2() const;
  /// Looks at surface voxels that counted, so far.
  std::uint64_t looks_counted() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Unit estimate of the outward surface normal at an occupied spot, from the occupied and free
/// voxels around it; zero when unknown.
Vec3 surface_normal(const VoxelMap& map, const Vec3& p, const Vec3& seen_from);

}  // namespace muster::map
