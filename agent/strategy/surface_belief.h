#pragma once

#include <array>
#include <vector>

#include "common/robot/knowledge.h"

namespace muster::agent {

/// A look at an area that the camera refused.
struct RefusedLook {
  Vec3 from = Vec3::UnitX();  ///< unit, area → camera
  double range_m = 2;
  double clear = 1;  ///< chance that nothing stood in the way
};

/// Which way the surface at an area of interest may face: weights over directions of the whole
/// sphere. What counts, in this order: whence it was sighted (a surface is only seen from its
/// front), which of the directions a slab of occupied voxels around it is square to, and from where
/// a look at it was refused. One estimated normal is not enough: a level camera of ±30° sees a flat
/// roof within 60° of incidence only from a narrow band of elevations, and a column from one side.
class SurfaceBelief {
 public:
  SurfaceBelief(const map::VoxelMap& map, const mission::Area& area,
                const mission::InspectConfig& rule, const mission::Vehicle& vehicle);

  void refuse(const RefusedLook& look);
  /// A look along unit `from` (area → camera) found a feature here: its surface meets the rule from
  /// there.
  void accept(const Vec3& from);

  /// Probability that the surface shows its front towards unit `from`, at whatever incidence: that
  /// a detector there can sight it.
  double shows(const Vec3& from) const;
  /// Probability that a look along unit `from` (area → camera) meets the surface within the rule's
  /// incidence.
  double faces(const Vec3& from) const;
  /// Probability that it lies within the camera's field of view and range from there, with the area
  /// known to its sigma. Line of sight is the map's business.
  double in_view(const Vec3& from, double range_m) const;

  /// Mean of the directions, unit.
  Vec3 normal() const;

 private:
  double square_enough(const Vec3& normal, const Vec3& from) const;
  void tabulate();
  void normalise();

  mission::InspectConfig rule_;
  mission::Vehicle vehicle_;
  double sigma_m_;
  std::vector<double> weights_;        // of directions()
  std::array<double, 1024> square_{};  // by the cosine of the incidence, −1…1
};

}  // namespace muster::agent
