#pragma once

#include <array>
#include <unordered_map>
#include <vector>

#include "common/core/time.h"
#include "common/map/voxel_map.h"
#include "common/mission/mission.h"

namespace muster::world {

/// Idle and wasted time per role (RULES "What is counted"), from what robots did, never from what
/// they say:
///
///   | role      | idle                                        | waste |
///   |-----------|---------------------------------------------|-----------------------------------------------------------|
///   | station   | standing still                              | – | | explorer  | not exploring |
///   not exploring                                             | | inspector | no inspection
///   running                       | no inspection running, and not on the way to one          |
///
/// An explorer explores in a second in which its sensor adds ≥ 50 voxels (0.2 m, inside a box) to
/// what it has seen. An inspector was on its way when the motion, without a rest of 2 s, ended in
/// an inspection.
class ActivityMeter {
 public:
  explicit ActivityMeter(const mission::Mission& mission);

  /// An explorer's sweep: the true ends of its rays.
  void saw(std::size_t robot, const Vec3& from, const std::vector<Vec3>& ray_ends,
           std::uint32_t columns);

  struct Doing {
    bool alive = true, inspecting = false;
    double speed_mps = 0;
  };
  /// One tick has passed for every robot (in the world's order). Not called after the declaration.
  void tick(const std::vector<Doing>& robots);

  struct Totals {
    double gcs_s = 0, explorers_s = 0, inspectors_s = 0;
    double total() const { return gcs_s + explorers_s + inspectors_s; }
  };
  Totals idle() const;
  Totals waste() const;
  /// How long this robot explored or inspected so far; for `muster report`.
  double worked_s(std::size_t robot) const {
    return static_cast<double>(robots_[robot].worked_ticks) / 10;
  }

 private:
  /// Voxels seen, as blocks of 16³ bits: cheap to fill along rays, whatever the site's size.
  class SeenVoxels {
   public:
    bool insert(map::VoxelKey k);

   private:
    using Block = std::array<std::uint64_t, 64>;
    std::unordered_map<std::uint64_t, Block> blocks_;  ///< looked up only, never walked
    std::uint64_t last_key_ = ~std::uint64_t{0};
    Block* last_ = nullptr;
  };
  struct Robot {
    mission::Role role{};
    SeenVoxels seen;
    std::uint32_t new_voxels = 0;  ///< in this second
    int second_ticks = 0;          ///< of this second, alive
    int rest_ticks = 0, pending_ticks = 0;
    std::int64_t idle_ticks = 0, waste_ticks = 0, worked_ticks = 0;
  };
  void tick_explorer(Robot& r, bool second_ends);
  void tick_inspector(Robot& r, const Doing& doing);

  std::vector<Box> boxes_;
  double resolution_m_;
  std::vector<Robot> robots_;
  std::uint64_t ticks_ = 0;
};

}  // namespace muster::world
