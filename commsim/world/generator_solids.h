#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/core/error.h"
#include "commsim/world/scene.h"

namespace muster::world {

using Vec2 = Eigen::Vector2d;
using Outline = std::vector<Vec2>;  ///< corners of a convex polygon, counter-clockwise from above
using Ring = std::vector<Vec3>;

Outline rectangle(double width, double depth, const Vec2& center = Vec2::Zero());
/// A regular polygon with `apothem` from its centre to the middle of each side; a side faces −y.
Outline polygon(int sides, double apothem);
Outline scaled(const Outline& outline, double factor);

/// Collects closed solids in a local frame (a place and a turn about z), from which bigger things
/// are made. Every solid's faces look outwards, whatever order its corners come in.
class Solids {
 public:
  struct Frame {
    Vec3 origin = Vec3::Zero();
    double yaw_rad = 0;
  };
  const Frame& frame() const { return frame_; }
  void set_frame(const Frame& frame) { frame_ = frame; }
  /// `inner`, given in the current frame, as a frame of the world.
  Frame nested(const Frame& inner) const;

  /// A skin over rings of equally many corners, closed by fans at both ends.
  void loft(const std::vector<Ring>& rings);
  void box(const Vec3& low, const Vec3& high);
  void prism(const Outline& outline, double z0, double z1);
  void frustum(const Outline& bottom, double z0, const Outline& top, double z1);
  void column(const Vec2& center, double radius, double z0, double z1, int sides = 8);
  /// The convex profile (along, up) carried along y (`along_x` false: profile in x) or along x
  /// (true: profile in y) from `from` to `to`.
  void extrude(const Outline& profile, bool along_x, double from, double to);
  /// A tiled roof: from `eaves` up to `ridge` (as many corners) with a slope that steepens towards
  /// the ridge, a rim of `thickness` and eaves that rise by `lift` at the corners.
  void swept_roof(const Outline& eaves, const Outline& ridge, double z, double rise, double lift,
                  double thickness = 0.25);
  /// Two sloping slabs over a house of `width` (across the ridge) with its walls' tops at z; the
  /// ridge runs along y, or x.
  void gable_roof(double width, double length, double z, double rise, double overhang,
                  bool ridge_along_x, double thickness = 0.22);
  /// A wall along x, centred on y = 0, with openings `{x0, z0, x1, z1}`.
  void wall(double length, double thickness, double z0, double z1,
            const std::vector<Eigen::Vector4d>& openings);
  /// A block of `width` × `depth` with a vaulted passage along y: straight sides up to `spring_z`,
  /// then a half circle.
  void arch(double width, double depth, double height, double opening, double spring_z);

  Mesh take() { return std::move(mesh_); }
  std::size_t vertex_count() const { return mesh_.vertices.size(); }
  const Mesh& mesh() const { return mesh_; }

 private:
  Vec3 to_world(const Vec3& p) const;

  Frame frame_;
  Mesh mesh_;
};

}  // namespace muster::world
