#pragma once

#include <array>

#include "common/map/region_cells.h"
#include "common/map/targets.h"

namespace muster::map {

/// Looks round from one spot through the map: rays in every direction of the compass, each until
/// it meets matter or the end of the sensor's range.
///
///     eye ───known free───┬──unknown──┬──unknown──▶   counts: unknown volume of the box
///      └──known free──▇ owed surface                  counts: area, once per look still owed
///
/// Unknown space is taken for transparent, so the volume is a hope; but a ray that enters it
/// through a frontier that was given up counts for nothing, so a hope that failed is not had again.
class PanoramaReader {
 public:
  PanoramaReader(const VoxelMap& map, const RegionCells& cells, const TargetConfig& config);

  Panorama around(const Vec3& eye) const;
  /// What the camera shows at one heading.
  Worth at(const Pose& pose) const;

 private:
  Worth column(const Vec3& eye, double yaw_rad, int column) const;

  const VoxelMap& map_;
  const RegionCells& cells_;
  TargetConfig config_;
  int columns_in_view_;
};

}  // namespace muster::map
