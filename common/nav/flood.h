#pragma once

#include <memory>

#include "common/nav/grid.h"

namespace muster::nav {

/// Travel distances from one voxel to every other, worked out as far as somebody asks (Dijkstra
/// with a bucket queue, stopped as soon as the asked voxel is settled and resumed by the next
/// question).
///
/// Only those steps are followed that no path around the voxel replaces: a shorter one, or an
/// equally short one that begins with more axes (diagonals before straights, as in jump point
/// search; the shortest path that is first in that order is never cut). An open voxel costs about
/// one relaxation instead of 26, and one beside a wall a few. Which steps they are depends on the
/// step that led to the voxel and on its 26 neighbours alone, and is remembered.
class Flood {
 public:
  explicit Flood(Grid& grid);

  void start(Cell from, double max_length_m);
  /// The map changed: answers start anew.
  void invalidate() { running_ = false; }
  bool running() const { return running_; }
  bool exhausted() const { return running_ && queued_ == 0; }
  Cell from() const { return from_; }
  double max_length_m() const { return max_length_m_; }

  /// Length of the shortest path over voxels, infinity when there is none within the maximum.
  double distance_m(Cell to);

 private:
  static constexpr std::uint16_t kFar = 0xFFFF;
  static constexpr std::uint32_t kBuckets = 32;  ///< more than the longest step
  struct Content {
    std::array<std::uint16_t, 4096> cost;
    std::array<std::uint8_t, 4096> step;  ///< that led there; kNoStep: several, equally short
    void clear() { cost.fill(kFar); }
  };

  struct Worth {
    std::uint32_t around = 0;  ///< with the step in the bits above
    std::uint32_t steps = 0;
  };
  static constexpr std::uint32_t kRemembered = 1u << 14;

  void push(Cell to, std::uint32_t cost, int step);
  std::uint32_t worth(int step, std::uint32_t around);
  void expand(std::uint64_t id);
  void settle(Cell to);

  Grid& grid_;
  BlockPool<Content> pool_;
  std::vector<Worth> worth_;                                  ///< answers of worth_trying, by hash
  std::array<std::vector<std::uint64_t>, kBuckets> buckets_;  ///< ids
  std::uint32_t cost_ = 0, limit_ = 0;
  std::size_t queued_ = 0;
  bool running_ = false;
  Cell from_;
  double max_length_m_ = 0;
};

}  // namespace muster::nav
