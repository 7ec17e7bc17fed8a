#pragma once

#include <vector>

#include "common/core/time.h"
#include "common/map/voxel_map.h"

namespace muster::robot {

/// A sensor sees `p`, unless something is in between.
bool in_view(const map::RangeScan& scan, const Vec3& p);

/// Bodies that the camera sees and nobody announces (radio off, dead robots): obstacles to
/// everybody until their place is seen free again, or for a few seconds, because what stands may
/// stand on when the camera turns away.
class SeenBodies {
 public:
  /// Returns of a scan that fit neither the map nor a teammate.
  void see(SimTime now, const std::vector<Vec3>& unexplained);
  /// What a scan saw through is no obstacle any more.
  void see_through(const map::VoxelMap& map, const map::RangeScan& scan,
                   const std::vector<Vec3>& unexplained);
  void forget(SimTime now);

  /// As of the last `forget`.
  const std::vector<map::Sphere>& spheres() const { return spheres_; }
  /// One in `around` that was seen within the last second has nothing to stand on.
  bool in_the_air(const map::VoxelMap& map, const map::Sphere& around, SimTime now) const;
  /// One stands on the ground below `p`, or is as high as a body of `radius_m` there.
  bool below(const Vec3& p, double radius_m) const;

 private:
  struct Obstacle {
    Vec3 p;
    SimTime until;
  };
  std::vector<Obstacle> obstacles_;
  std::vector<map::Sphere> spheres_;
};

}  // namespace muster::robot
