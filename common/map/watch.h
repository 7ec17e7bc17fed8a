#pragma once

#include <unordered_map>

#include "common/map/block_store.h"

namespace muster::map {

/// Counts the known voxels of one box; looks only at blocks that changed since it was last asked.
class Watch {
 public:
  Watch(const Box& box, const MapConfig& config);
  double known_m3(const BlockStore& blocks);
  double volume_m3() const { return static_cast<double>(voxels_) * voxel_m3_; }

 private:
  struct Part {
    Plane inside;
    int known = 0;
  };
  double voxel_m3_;
  std::int64_t voxels_ = 0, known_ = 0;
  std::uint64_t cursor_ = 0;
  std::unordered_map<std::uint64_t, Part> parts_;
};

}  // namespace muster::map
