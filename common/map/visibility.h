#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "common/map/region_cells.h"
#include "common/map/targets.h"

namespace muster::map {

/// A voxel and the spots that must be in view for it to count as seen: for a frontier the unknown
/// voxels beside it, for a surface the spots just before its owed faces.
struct Aim {
  VoxelKey cell;
  double weight = 1;      ///< of a surface: what a look promises
  Sectors exhausted = 0;  ///< whence it shows nothing new
  struct Spot {
    Vec3 at;
    int face;  ///< index of kFaces; −1: from any side
  };
  std::vector<Spot> spots;
};
Aim frontier_aim(const VoxelMap& map, const RegionCells& cells, VoxelKey frontier);
Aim surface_aim(const VoxelMap& map, const RegionCells& cells, VoxelKey surface);

/// Can the aim be seen from `eye`, at any heading: range and line of sight through known free
/// voxels?
bool sighted(const VoxelMap& map, const Aim& aim, const Vec3& eye, double range_m);
/// Which faces of a surface's aim can be.
FaceSet faces_sighted(const VoxelMap& map, const Aim& aim, const Vec3& eye, double range_m);

/// Poses that see a cluster, found by trying a fixed pattern of bearings, heights and distances
/// around it.
class ViewpointSearch {
 public:
  struct Cluster {
    const std::vector<VoxelKey>* cells;
    bool surface;
    const std::vector<Vec3>* avoid;  ///< spots that were of no use
    double least_m2;                 ///< a pose for less is not worth the way
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
  /// Frontier, or what surfaces promise, m².
  double area_in_view(const Pose& pose, bool surface) const;
  /// Unknown volume of the box that the camera would look into if it were all free, m³.
  double volume_in_view(const Pose& pose) const;

  const VoxelMap& map_;
  RegionCells& cells_;
  TargetConfig config_;
};

}  // namespace muster::map
