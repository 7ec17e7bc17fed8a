#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/core/ids.h"
#include "common/core/time.h"
#include "common/geometry/box.h"
#include "common/geometry/camera.h"

namespace octomap {
class OcTree;
}

namespace muster::map {

enum class Voxel : std::uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2 };

/// Index of a voxel: floor(coordinate / resolution) per axis.
struct VoxelKey {
  int x = 0, y = 0, z = 0;
  auto operator<=>(const VoxelKey&) const = default;
};
/// Index of a block of 16³ voxels: floor(voxel / 16).
struct BlockKey {
  int x = 0, y = 0, z = 0;
  auto operator<=>(const BlockKey&) const = default;
};
inline constexpr int kBlockSide = 16;
inline BlockKey block_of(VoxelKey v) { return {v.x >> 4, v.y >> 4, v.z >> 4}; }
/// One number per block, for record keys; 21 bits per axis, offset binary.
std::uint64_t pack(BlockKey b);
BlockKey unpack_block(std::uint64_t key);

/// One bit per voxel of a block: voxel (x, y, z) at bit x + 16·y + 256·z of 64 words, so a row
/// along x is 16 neighbouring bits and a whole block is compared, merged or counted in 64 steps.
using Plane = std::array<std::uint64_t, 64>;

struct States {
  Plane free{}, occupied{};
};

/// What somebody says of some voxels of a block; of the others, what was said before still holds.
struct SaidBlock {
  BlockKey key;
  States said;
};

/// Leaves out of `older` what `newer` says anything of.
void take_back(States& older, const States& newer);

struct MapConfig {
  double resolution_m = 0.2;
  Box bounds;  ///< nothing more than a voxel outside is mapped, and no body may be outside
  double body_radius_m = 0.25;
  double clearance_m = 0.1;  ///< kept between the body and anything occupied
  bool ground = false;       ///< traversability of a UGV instead of a UAV
  double ride_height_m = 0.4;
};

/// One sweep in the map's own terms (see bus.idl Scan for the layout).
struct RangeScan {
  SimTime time;  ///< when it was measured: a strange return must last before it becomes map
  Pose sensor;
  double pitch_rad = 0;
  std::uint32_t columns = 0, rows = 0;
  double hfov_rad = 0, vfov_rad = 0, range_m = 0;
  std::span<const std::uint16_t> range_mm;
};

/// The merged voxels of one block as bits, voxel (x, y, z) at bit x + 16·y + 256·z of 64 words.
/// Null where nothing is known yet. Valid until the map changes.
struct BlockView {
  const std::uint64_t* free = nullptr;
  const std::uint64_t* occupied = nullptr;
  const std::uint64_t* traversable = nullptr;
  const std::uint64_t* blocked = nullptr;
  explicit operator bool() const { return free != nullptr; }
};

/// A body that must not become part of the map: a teammate where it says it is.
struct Sphere {
  Vec3 center = Vec3::Zero();
  double radius_m = 0;
};

/// What a robot knows of the place: its own evidence (an OctoMap OcTree, from its own scans only)
/// merged with what others said.
///
///     own OcTree ─────┐ (evidence, log-odds)
///                     ├─▶ merged block grid (unknown | free | occupied)
///     others' words ──┘     ─▶ traversability counts, frontiers, paths
///     (others': the last word of each author on each voxel)
///
/// A merged voxel: occupied when the own map or any author's last word says occupied and the own
/// map does not say free; else free when anyone says free; else unknown. Own evidence wins over
/// others'.
class VoxelMap {
 public:
  explicit VoxelMap(const MapConfig& config);
  ~VoxelMap();

  const MapConfig& config() const;
  VoxelKey key(const Vec3& p) const;
  Vec3 center(VoxelKey k) const;

  /// Known free around the start (RULES "What a robot may know").
  void insert_free_ball(const Vec3& center, double radius_m);
  /// The same, only of what nobody knows anything of.
  void suppose_free_ball(const Vec3& center, double radius_m);
  /// The same, whatever anybody has seen there: the own body was there.
  void clear_ball(const Vec3& center, double radius_m);
  /// What others call occupied there and own scans have never measured is held free from now on.
  void disbelieve_others(const Vec3& center, double radius_m);

  struct Integrated {
    std::uint32_t changed = 0;      ///< merged voxels whose state changed
    std::vector<Vec3> unexplained;  ///< returns inside space that the own map holds free, fitting
                                    ///< no teammate: maybe a body
  };
  /// Shared free space of the rays is traced once; a voxel with a hit stays occupied over misses of
  /// the same scan. Returns within a teammate's sphere (grown by a margin) are neither mapped nor
  /// traced beyond.
  Integrated integrate(const RangeScan& scan, std::span<const Sphere> teammates);

  Voxel at(VoxelKey k) const;
  Voxel at(const Vec3& p) const { return at(key(p)); }
  /// The own evidence; blocks still waiting to be written to it are written first.
  const octomap::OcTree& own() const;
  BlockView view(BlockKey b) const;

  /// The body's centre may be in this voxel: nothing occupied within radius + clearance and nothing
  /// unknown within the body (UGV: on its driving plane, see README). Kept up to date
  /// incrementally, O(1).
  bool traversable(VoxelKey k) const;
  bool traversable(const Vec3& p) const { return traversable(body_key(p)); }
  /// An occupied voxel is within radius + clearance of this voxel's centre (or it lies outside the
  /// bounds). Neither blocked nor traversable: unknown space that may turn out passable; transit
  /// plans through it and looks before it goes.
  bool blocked(VoxelKey k) const;
  /// The same of all voxels of a block without a `view`, in its layout: what known neighbours and
  /// the bounds block of it.
  std::array<std::uint64_t, 64> blocked_where_unknown(BlockKey b) const;
  /// The voxel that decides about a body at `p`: key(p); for a UGV within 0.3 m of its driving
  /// plane, the one in that plane.
  VoxelKey body_key(const Vec3& p) const;
  /// Distance from `p` to the nearest occupied voxel's cube, at most `cap_m`.
  double clearance(const Vec3& p, double cap_m) const;
  /// No occupied voxel strictly between the voxels of `a` and `b` (unknown counts as blocking when
  /// `through_unknown` is false).
  bool line_of_sight(const Vec3& a, const Vec3& b, bool through_unknown) const;

  // ---- exchange
  /// Own blocks changed since the cursor (0 at first), which is advanced. Ordered.
  std::vector<BlockKey> own_changes(std::uint64_t& cursor) const;
  /// All that the own map knows of a block.
  SaidBlock own_block(BlockKey b) const;
  /// Own evidence of an earlier start: where the own map knows nothing, it counts like one look.
  void adopt_own(const SaidBlock& block);
  /// What of the own evidence would change the picture of somebody who has heard all that this map
  /// has merged and all that was `told`: and where the own evidence has changed its mind.
  std::optional<SaidBlock> news(BlockKey b) const;
  /// This was said to others.
  void told(const SaidBlock& block);
  /// Takes the word of `author` in place of what it said before of these voxels. Its words have to
  /// be merged in the order in which they were said.
  void merge(RobotId author, const SaidBlock& block);

  // ---- change feed for frontiers and planners
  /// Blocks whose merged voxels changed since the cursor (0 at first), which is advanced. Ordered.
  std::vector<BlockKey> changes(std::uint64_t& cursor) const;
  std::uint64_t revision() const;  ///< grows with every change of a merged voxel

  /// Volume of `box` that is known (free or occupied), m³. Incremental for boxes registered by
  /// `watch`.
  std::size_t watch(const Box& box) const;
  double known_m3(std::size_t watched) const;
  double volume_m3(std::size_t watched) const;

  /// All merged voxels as an OctoMap file (`map.bt`). Throws Failure.
  void write_bt(const std::string& path) const;

 private:
  std::vector<VoxelKey> ball(const Vec3& p, double radius_m) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace muster::map
