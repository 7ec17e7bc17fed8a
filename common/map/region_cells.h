#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "common/map/cell_clusters.h"

namespace muster::map {

/// Bit i: the face towards kFaces[i].
using FaceSet = std::uint8_t;
/// The cosine of the most grazing view that shows a face.
inline constexpr double kLeastFacing = 0.15;
inline Vec3 face_normal(int face) {
  const VoxelKey& d = kFaces[face];
  return {static_cast<double>(d.x), static_cast<double>(d.y), static_cast<double>(d.z)};
}

/// The voxels of one box that are worth looking at, kept up to date block by block:
///
/// | marks      | a voxel that is … |
/// |------------|--------------------------------------------------------------------------------------|
/// | frontier   | free, in the box, beside an unknown one in the box, and not given up | | owed |
/// occupied, in the box, at least 0.8 m high, beside a free one, looked at too rarely,  | | | or
/// never from the side of one of its open faces                                      |
///
/// A look from above says nothing of what hangs below an eave that is one voxel thick. A face up or
/// down is asked for only beside an open side: the middle of a floor or ceiling is not in the way
/// of anything, and nobody inspects it at 60° of incidence with a level camera.
class RegionCells {
 public:
  RegionCells(const VoxelMap& map, const Box& box, std::uint32_t looks, double max_extent_m);

  /// Takes in what changed in the map.
  void update();
  /// Voxels of the box that became known since the start; never shrinks.
  std::uint64_t growth() const { return growth_; }
  bool any_known() const { return growth_ > 0; }

  CellClusters& frontier() { return frontier_; }
  CellClusters& owed() { return owed_; }

  bool unknown_in_box(VoxelKey k) const {
    const std::size_t i = index_of(block_of(k));
    return i != kNone && bit(slots_[i].unknown, local_index(k));
  }
  /// Are faces owed looks of their own? True at first. Takes effect with `settle`.
  void ask_for_sides(bool ask);
  /// The faces from whose side this surface voxel is still owed a look.
  FaceSet owed_faces(VoxelKey k) const;
  /// A look from `eye` would show one of them, if nothing is in between.
  bool owed_from(VoxelKey k, const Vec3& eye) const;
  std::uint64_t looks_counted() const { return looks_counted_; }
  bool given_up(VoxelKey k) const {
    const std::size_t i = index_of(block_of(k));
    return i != kNone && bit(slots_[i].given_up, local_index(k));
  }
  /// A scan should have resolved this frontier voxel and did not. After a few times it is given up.
  void looked_in_vain(VoxelKey frontier);
  /// These faces of a surface voxel were in view at a look of the detector.
  void count_look(VoxelKey surface, FaceSet faces);
  /// Surface voxels that came to be owed looks since the last call: earlier looks may have had them
  /// in view before they were known. Every voxel is told of once.
  std::vector<VoxelKey> take_new_surface() { return std::exchange(new_surface_, {}); }
  /// Applies what `looked_in_vain` and `count_look` noted.
  void settle();

  /// Marked cells of `clusters` in blocks within `range_m` of `p`, in order.
  template <class Visit>
  void near(const CellClusters& clusters, const Vec3& p, double range_m, Visit visit) const {
    const double side = map_.config().resolution_m * kBlockSide;
    for (std::size_t s = 0; s < slots_.size(); ++s) {
      const Vec3 low = Vec3(slots_[s].key.x, slots_[s].key.y, slots_[s].key.z) * side;
      const Vec3 outside = (low - p).cwiseMax(p - low - Vec3::Constant(side)).cwiseMax(0.0);
      if (outside.squaredNorm() > range_m * range_m) continue;
      for_each_bit(clusters.marks(s), [&](int i) { visit(voxel_in(slots_[s].key, i)); });
    }
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  struct Slot {
    BlockKey key;
    Plane inside{}, unknown{}, high_enough{};
    Plane given_up{}, seen{}, told{};
    std::map<int, std::uint8_t> vain;  ///< few
    std::vector<std::uint8_t> looks;   ///< empty until the first
    std::array<Plane, 6> face_seen{};
    int known = 0;
    bool dirty = false;
  };
  std::size_t index_of(BlockKey b) const {
    const int x = b.x - first_.x, y = b.y - first_.y, z = b.z - first_.z;
    const bool inside = x >= 0 && x < nx_ && y >= 0 && y < ny_ && z >= 0 && z < nz_;
    return inside ? static_cast<std::size_t>((x * ny_ + y) * nz_ + z) : kNone;
  }
  Slot* slot_of(BlockKey b) {
    const std::size_t i = index_of(b);
    return i == kNone ? nullptr : &slots_[i];
  }
  void mark_around(std::size_t slot);
  void recompute(std::size_t slot);

  const VoxelMap& map_;
  std::uint32_t looks_;
  bool sides_ = true;
  std::vector<Slot> slots_;
  BlockKey first_;  ///< slots are in order of x, y, z from here
  int nx_ = 0, ny_ = 0, nz_ = 0;
  CellClusters::Neighbours neighbours_;
  CellClusters frontier_, owed_;
  std::vector<VoxelKey> new_surface_;
  std::uint64_t cursor_ = 0, growth_ = 0, looks_counted_ = 0;
};

}  // namespace muster::map
