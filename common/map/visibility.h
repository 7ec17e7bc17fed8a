#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "common/map/region_cells.h"
#include "common/map/targets.h"

namespace muster::map {

/// A frontier voxel and the unknown voxels beside it, one of which must be in view for it to count
/// as seen; or a surface voxel and its faces that are owed looks.
struct Aim {
  VoxelKey cell;
  std::vector<Vec3> spots;        ///< frontier
  FaceSet open = 0, owed = 0;     ///< surface
  std::array<double, 6> value{};  ///< of a look at each owed face; frontier: 1 at [0]
  double most = 1;
};
Aim frontier_aim(const VoxelMap& map, const RegionCells& cells, VoxelKey frontier);
Aim surface_aim(const RegionCells& cells, VoxelKey surface);

/// Can a frontier be seen from `eye`, at any heading: range and line of sight through known free
/// voxels?
bool sighted(const VoxelMap& map, const Aim& frontier, const Vec3& eye, double range_m);

/// The owed faces that a look from `eye` counts for: those in sight from their own side, and those
/// of a slanting surface or a corner, where another face of the voxel is. Never both sides of a
/// voxel that is open on two opposite ones.
FaceSet faces_sighted(const VoxelMap& map, const Aim& surface, const Vec3& eye, double range_m);
/// Poses that see a cluster, found by trying a fixed pattern of bearings, heights and distances
/// around it.
class ViewpointSearch {
 public:
  struct Cluster {
    const std::vector<VoxelKey>* cells;
    bool surface;
    const std::vector<Vec3>* avoid;  ///< spots that were of no use
  };
  ViewpointSearch(const VoxelMap& map, RegionCells& cells, const TargetConfig& config);

  /// The best one or two; empty when no reachable pose sees enough of it.
  std::vector<Viewpoint> find(const Cluster& cluster,
                              const std::function<bool(const Vec3&)>& reachable) const;
  /// The field of view that is relied on: a little less than the camera's.
  FieldOfView reliable(bool surface) const;

 private:
  struct Candidate {
    Pose pose;
    std::vector<std::uint32_t> sees;  ///< indices of aims
    double score = 0;
  };
  std::vector<Aim> aims(const Cluster& cluster) const;
  std::optional<Candidate> judge(const std::vector<Aim>& aims, const Vec3& eye, bool surface) const;
  double value_seen(const Aim& aim, const Vec3& eye, bool surface, double range_m) const;
  double area_in_view(const Pose& pose, bool surface) const;
  /// Unknown volume of the box that the camera would look into if it were all free, m³.
  double volume_in_view(const Pose& pose) const;

  const VoxelMap& map_;
  RegionCells& cells_;
  TargetConfig config_;
};

}  // namespace muster::map
