#pragma once

#include <vector>

#include "common/core/time.h"
#include "common/map/voxel_map.h"
#include "common/nav/path_finder.h"

namespace muster::robot {

/// Where the camera has looked lately. Who flies looks where it flies, because dead robots stand
/// about that nobody announces and no map shows; where they would have been seen a moment ago, or
/// cannot stand, the camera is free to turn to what it will be needed for.
class Lookout {
 public:
  void looked(SimTime now, const map::RangeScan& scan);

  /// Nobody stands silent along `path`: everywhere the camera has looked within seconds, or there
  /// is nothing to stand on. (The first places are the body's own.)
  bool clear(const nav::Path& path, const map::VoxelMap& map, SimTime now, double radius_m) const;

 private:
  bool seen(const Vec3& p, const map::VoxelMap& map, SimTime now) const;

  std::vector<map::RangeScan> glances_;  // without their ranges, the latest last
};

}  // namespace muster::robot
