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

/// Where looks at a surface come from: bit i for the i-th eighth of the compass.
using Sectors = std::uint8_t;
Sectors sector_of(const Vec3& surface_to_eye);

/// The voxels of one box that are worth looking at, kept up to date block by block. Marks:
///
/// - frontier: free, in the box, beside an unknown voxel in the box, and not given up;
/// - owed: occupied, in the box, at least 0.8 m high, beside a free one, and looks may still show
///   something there that none has shown.
///
/// What a look may show is not the same everywhere. A voxel seen from above says nothing of what
/// hangs below an eave that is one voxel thick, so an open face is owed a look from its own side;
/// but most side faces are steps that noise has made in a roof. `promise` says how much of a
/// surface is likely there that no look has shown: measured, see the README of this folder.
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
  /// The faces from whose side this surface voxel is still owed a look.
  FaceSet owed_faces(VoxelKey k) const;
  /// The sectors from which a look would show nothing new of it.
  Sectors exhausted_sectors(VoxelKey k) const;
  /// How much a look at this surface voxel promises, 0 to 1: 1 for one that nobody looked at, with
  /// an edge in the open; 0: it is owed nothing.
  double promise(VoxelKey k) const;
  /// What a look from `eye` promises, if nothing is in between.
  double promise_from(VoxelKey k, const Vec3& eye) const;
  /// Does something stand out above this face, so that what is just below it shows from below only?
  bool overhung(VoxelKey k, int face) const;
  /// Whether corners below overhangs promise anything once they are owed nothing else. True at
  /// first.
  void ask_for_nooks(bool asked) { nooks_asked_ = asked; }
  bool nooks_asked() const { return nooks_asked_; }
  std::uint64_t looks_counted() const { return looks_counted_; }
  /// Surface voxels that were owed looks at some time.
  std::uint64_t surfaces() const { return surfaces_; }
  bool given_up(VoxelKey k) const {
    const std::size_t i = index_of(block_of(k));
    return i != kNone && bit(slots_[i].given_up, local_index(k));
  }
  /// A scan should have resolved this frontier voxel and did not. After a few times it is given up.
  void looked_in_vain(VoxelKey frontier);
  /// These faces of a surface voxel were in view at a look of the detector, from `eye`.
  void count_look(VoxelKey surface, FaceSet faces, const Vec3& eye);
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
    Plane given_up{}, told{};
    Plane once{}, seen{};              ///< looked at once, often enough
    Plane nook{};                      ///< owed looks from other sectors only
    std::map<int, std::uint8_t> vain;  ///< few
    std::vector<std::uint8_t> looks;   ///< empty until the first
    std::vector<Sectors> sectors;      ///< that looks came from; likewise
    std::array<Plane, 6> face_seen{};
    std::vector<std::uint8_t> promise;  ///< of owed voxels, percent; empty until the first
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
  struct Surfaces;
  void weigh(Slot& slot, const Surfaces& surfaces, Plane& owed) const;
  void weigh_nooks(Slot& slot, const Surfaces& surfaces, Plane& owed) const;
  /// Of a surface voxel: faces towards free voxels, those of them to the side, and those that no
  /// look has shown.
  struct Faces {
    FaceSet open = 0, lateral = 0, unseen = 0;
  };
  Faces faces_of(const Slot& slot, VoxelKey k) const;
  int support(VoxelKey k, FaceSet faces) const;
  Plane under_overhang(BlockKey b) const;
  Sectors sectors_at(VoxelKey k) const;
  Sectors sectors_around(VoxelKey k) const;

  const VoxelMap& map_;
  std::uint32_t looks_;
  std::vector<Slot> slots_;
  BlockKey first_;  ///< slots are in order of x, y, z from here
  int nx_ = 0, ny_ = 0, nz_ = 0;
  CellClusters::Neighbours neighbours_;
  CellClusters frontier_, owed_;
  std::vector<VoxelKey> new_surface_;
  bool nooks_asked_ = true;
  std::uint64_t cursor_ = 0, growth_ = 0, looks_counted_ = 0, surfaces_ = 0;
};

}  // namespace muster::map
