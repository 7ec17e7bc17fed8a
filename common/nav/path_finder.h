#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/map/voxel_map.h"

namespace muster::nav {

/// A polyline through traversable space: every straight piece keeps body and clearance off
/// everything occupied or unknown.
struct Path {
  std::vector<Vec3> points;
  double length_m() const;
};

struct PathResult {
  std::optional<Path> path;
  std::string reason;  ///< why not, when there is none: "goal is not traversable", "no way through
                       ///< known space", "search limit"
};

/// A* over traversable voxels (26-neighbourhood; UGV: its driving plane), then shortened by
/// line-of-traversability. Work is bounded by counted expansions, never by time. Prefers a little
/// more clearance where it costs little.
class PathFinder {
 public:
  explicit PathFinder(const map::VoxelMap& map, std::uint32_t max_expansions = 400'000);
  ~PathFinder();

  /// `start` may be slightly inside clearance (a body that drifted): the nearest traversable voxel
  /// within 0.6 m is used. The goal likewise within `goal_tolerance_m`. `blocked`: spheres to be
  /// avoided now (short-lived obstacles, parked teammates).
  PathResult find(const Vec3& start, const Vec3& goal, double goal_tolerance_m = 0.3,
                  std::span<const map::Sphere> blocked = {});

  /// As `find`, but through everything that is not `blocked`: unknown space costs `unknown_factor`
  /// times its length, and steep climbs through it more (the camera does not look up). Only the
  /// returned path's part up to the first non-traversable point may be flown; it is `known`, the
  /// whole is `path`. For transit: fly `known`, look, plan again. `avoid`: spheres in unknown space
  /// that led nowhere before.
  struct Transit {
    std::optional<Path> path;
    Path known;
    std::string reason;
  };
  Transit find_through_unknown(const Vec3& start, const Vec3& goal, double goal_tolerance_m,
                               std::span<const map::Sphere> avoid = {},
                               std::span<const map::Sphere> blocked = {},
                               double unknown_factor = 2);

  /// Path lengths from `start` to each goal (infinity: unreachable within `max_length_m`): one
  /// Dijkstra flood for many goals. Cached until the map's revision or the start voxel changes.
  std::vector<double> distances(const Vec3& start, std::span<const Vec3> goals,
                                double max_length_m = 1e9);
  /// Is p in the component of traversable space that `start` of the last flood is in? Cheap after
  /// `flood(start)`.
  void flood(const Vec3& start, double max_length_m = 1e9);
  bool reached(const Vec3& p) const;
  double flood_distance(const Vec3& p) const;  ///< infinity when not reached
  /// Nothing traversable about `within_m` from `start` can be reached from there. Moves the flood.
  bool confined(const Vec3& start, double within_m);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace muster::nav
