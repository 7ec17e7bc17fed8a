#pragma once

#include <array>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "common/map/cell_clusters.h"

namespace muster::map {

/// What the detector's looks at the faces of one block's surface voxels came to.
///
/// A thin wall or eave is one voxel with two sides, and a look at one side says nothing about what
/// sits on the other: looks are counted for every open face, that is, one towards a free voxel.
struct FaceLooks {
  std::array<Plane, 6> open{}, owed{}, seen{}, told{};
  std::vector<std::uint16_t> counts = std::vector<std::uint16_t>(kBlockVoxels, 0);  ///< 2 bits each

  std::uint32_t count(int voxel, int face) const {
    return counts[static_cast<std::size_t>(voxel)] >> (2 * face) & 3u;
  }
};
inline constexpr std::uint32_t kMostLooks = 3;  ///< that are counted
inline constexpr double kLookValue[kMostLooks + 1] = {1, 0.5, 0.25, 0};
inline constexpr double kMissed[kMostLooks + 1] = {1, 0.1, 0.01, 0.001};

/// Surfaces that face up, or down, and are more level than this are not owed looks.
struct LeastTilt {
  double up_rad = 0, down_rad = 0;
};

/// Faces of a voxel, bit i: towards kFaces[i].
using FaceSet = std::uint8_t;

/// The voxels of one box that are worth looking at, kept up to date block by block:
///
/// | marks    | a voxel that is …                                                              |
/// |----------|--------------------------------------------------------------------------------|
/// | frontier | free, in the box, beside an unknown one in the box, and not given up           |
/// | owed     | occupied, in the box, at least 0.8 m high, with an open face that was looked at |
/// |          | too rarely                                                                     |
class RegionCells {
 public:
  RegionCells(const VoxelMap& map, const Box& box, std::uint32_t looks, double max_extent_m,
              const LeastTilt& least_tilt = {});

  /// Takes in what changed in the map.
  void update();
  /// Voxels of the box that became known since the start; never shrinks.
  std::uint64_t growth() const { return growth_; }
  bool any_known() const { return growth_ > 0; }

  CellClusters& frontier() { return frontier_; }
  CellClusters& owed() { return owed_; }
  const CellClusters& owed() const { return owed_; }

  bool unknown_in_box(VoxelKey k) const {
    const std::size_t i = index_of(block_of(k));
    return i != kNone && bit(slots_[i].unknown, local_index(k));
  }
  /// Faces of a surface voxel towards free space; those of them that are owed looks.
  FaceSet open_faces(VoxelKey k) const { return faces(k, &FaceLooks::open); }
  FaceSet owed_faces(VoxelKey k) const { return faces(k, &FaceLooks::owed); }
  /// What one more look at an owed face is worth: 1 for the first, less for each further one.
  double look_value(VoxelKey k, int face) const { return kLookValue[looks(k, face)]; }
  /// How likely a feature on a surface voxel is still hidden, summed over the voxel's sides: 1 for
  /// a side that was never looked at, `kMiss` times less for every look.
  double hidden(VoxelKey k) const;
  /// Looks that this face of a surface voxel had, at most kMostLooks.
  std::uint32_t looks(VoxelKey k, int face) const {
    const std::size_t i = index_of(block_of(k));
    return i == kNone || !slots_[i].looks ? 0 : slots_[i].looks->count(local_index(k), face);
  }
  std::uint64_t looks_counted() const { return looks_counted_; }
  /// Voxels' worth of `hidden` that looks have shown so far.
  double shown() const { return shown_; }
  bool given_up(VoxelKey k) const {
    const std::size_t i = index_of(block_of(k));
    return i != kNone && bit(slots_[i].given_up, local_index(k));
  }
  /// A scan should have resolved this frontier voxel and did not. After a few times it is given up.
  void looked_in_vain(VoxelKey frontier);
  /// These faces of a surface voxel were in view at a look of the detector.
  void count_look(VoxelKey surface, FaceSet faces);
  struct Surface {
    VoxelKey voxel;
    FaceSet faces;
  };
  /// Faces that came to be owed looks since the last call: earlier looks may have had them in view
  /// before they were known. Every face is told of once.
  std::vector<Surface> take_new_surface() { return std::exchange(new_surface_, {}); }
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
    Plane given_up{};
    std::map<int, std::uint8_t> vain;  ///< few
    std::unique_ptr<FaceLooks> looks;  ///< null until there is a surface
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
  FaceSet faces(VoxelKey k, const std::array<Plane, 6> FaceLooks::*which) const {
    const std::size_t i = index_of(block_of(k));
    if (i == kNone || !slots_[i].looks) return 0;
    const int at = local_index(k);
    FaceSet set = 0;
    for (int f = 0; f < 6; ++f) {
      if (bit((slots_[i].looks.get()->*which)[static_cast<std::size_t>(f)], at))
        set = static_cast<FaceSet>(set | 1u << f);
    }
    return set;
  }
  Plane recompute_surface(std::size_t slot, const std::array<Plane, 6>& free_ahead);
  void leave_level(Slot& slot, int face, double least_tilt_rad, const Plane& owed);
  std::uint32_t open_row(VoxelKey k, int face, int half) const;
  bool level(VoxelKey k, int face, double least_tilt_rad) const;
  void mark_around(std::size_t slot);
  void recompute(std::size_t slot);

  const VoxelMap& map_;
  std::uint32_t looks_;
  LeastTilt least_tilt_;
  std::vector<Slot> slots_;
  BlockKey first_;  ///< slots are in order of x, y, z from here
  int nx_ = 0, ny_ = 0, nz_ = 0;
  CellClusters::Neighbours neighbours_;
  CellClusters frontier_, owed_;
  std::vector<Surface> new_surface_;
  std::uint64_t cursor_ = 0, growth_ = 0, looks_counted_ = 0;
  double shown_ = 0;
};

}  // namespace muster::map
