#include "common/map/reach.h"

#include <algorithm>
#include <cmath>

#include "common/core/error.h"

namespace muster::map {
namespace {

constexpr int kMaxRadius = 7;          // a row of 16 and 8 more on each side are one 32-bit number
constexpr double kGroundLayerM = 0.2;  // below: the ground itself
constexpr double kHeadroomM = 0.1;     // above a UGV's body
constexpr int kSide = kBlockSide + 2 * kMaxRadius;

/// Row (y, z) of the 3×3×3 blocks around, y and z from −kMaxRadius: bit x + 8, with 8 voxels of the
/// neighbours on each side.
template <class PlaneOf>
std::uint32_t long_row(const Block& block, int y, int z, PlaneOf plane_of) {
  const int by = y < 0 ? 0 : y < kBlockSide ? 1 : 2, bz = z < 0 ? 0 : z < kBlockSide ? 1 : 2;
  const auto part = [&](int bx) -> std::uint32_t {
    const int i = bx + 3 * by + 9 * bz;
    const Block* b = block.around[static_cast<std::size_t>(i)];
    return b ? plane_of(*b, y & 15, z & 15) : 0;
  };
  return part(0) >> 8 | part(1) << 8 | part(2) << 24;
}

std::uint32_t occupied_row(const Block& b, int y, int z) {
  return row(b.merged.occupied.data(), y, z);
}
std::uint32_t known_row(const Block& b, int y, int z) {
  return row(b.merged.free.data(), y, z) | row(b.merged.occupied.data(), y, z);
}

std::uint32_t widen(std::uint32_t bits, int half) {
  std::uint32_t wide = bits;
  for (int i = 1; i <= half; ++i) wide |= bits << i | bits >> i;
  return wide;
}

void put_row(Plane& plane, int y, int z, std::uint32_t bits) {
  const int shift = (y & 3) << 4;
  std::uint64_t& word = plane[static_cast<std::size_t>(z << 2 | y >> 2)];
  word = (word & ~(std::uint64_t{0xFFFF} << shift)) | std::uint64_t{bits & 0xFFFFu} << shift;
}

}  // namespace

std::vector<Reach::Run> Reach::runs(const MapConfig& config, double reach_m, int radius, int dz_low,
                                    int dz_high) {
  // From a voxel's centre to the nearest point of a cube d voxels away: (d − ½) edges per axis. A
  // UGV counts distances in its plane.
  const auto gap = [&](int d) { return d == 0 ? 0.0 : (std::abs(d) - 0.5) * config.resolution_m; };
  std::vector<Run> result;
  for (int dz = dz_low; dz <= dz_high; ++dz) {
    for (int dy = -radius; dy <= radius; ++dy) {
      int half = -1;
      for (int dx = 0; dx <= radius; ++dx) {
        const double up = config.ground ? 0.0 : gap(dz);
        if (std::hypot(gap(dx), gap(dy), up) <= reach_m + 1e-9) half = dx;
      }
      if (half >= 0) result.push_back({dy, dz, half});
    }
  }
  return result;
}

Reach::Reach(const MapConfig& config) : ground_(config.ground) {
  const double reach_m = config.body_radius_m + config.clearance_m, edge = config.resolution_m;
  radius_ = static_cast<int>(std::floor(reach_m / edge + 0.5 + 1e-9));
  int dz_low = -radius_, dz_high = radius_, unknown_low = -radius_, unknown_high = radius_;
  if (ground_) {
    driving_layer_ = static_cast<int>(std::floor(config.ride_height_m / edge + 1e-9));
    const int lowest = static_cast<int>(std::ceil(kGroundLayerM / edge - 1e-9));
    const int highest = static_cast<int>(
        std::floor((config.ride_height_m + config.body_radius_m + kHeadroomM) / edge + 1e-9));
    dz_low = std::min(0, lowest - driving_layer_);
    dz_high = std::max(0, highest - driving_layer_);
    unknown_low = unknown_high = 0;
    radius_ = std::max({radius_, -dz_low, dz_high});
  }
  if (radius_ > kMaxRadius) {
    throw BadInput("map: body_radius_m: body and clearance must be below " +
                   std::to_string((kMaxRadius + 0.5) * edge) + " m at this resolution");
  }
  occupied_runs_ = runs(config, reach_m, radius_, dz_low, dz_high);
  unknown_runs_ = runs(config, config.body_radius_m, radius_, unknown_low, unknown_high);
  for (const Run& r : occupied_runs_) {
    for (int dx = -r.half; dx <= r.half; ++dx) blocking_offsets_.push_back({dx, r.dy, r.dz});
  }
}

void Reach::refresh(Block& block) const {
  int z_first = 0, z_last = kBlockSide - 1;
  if (ground_) {
    block.traversable.fill(0);
    block.blocked.fill(~std::uint64_t{0});
    if (block.key.z != driving_layer_ >> 4) return;
    z_first = z_last = driving_layer_ & 15;
  }
  std::uint32_t occupied[kSide][kSide], unknown[kSide][kSide];
  bool any_occupied = false;
  for (int z = z_first - radius_; z <= z_last + radius_; ++z) {
    for (int y = -radius_; y < kBlockSide + radius_; ++y) {
      const std::uint32_t o = long_row(block, y, z, occupied_row);
      occupied[z + kMaxRadius][y + kMaxRadius] = o;
      unknown[z + kMaxRadius][y + kMaxRadius] = ~long_row(block, y, z, known_row);
      any_occupied |= o != 0;
    }
  }
  for (int z = z_first; z <= z_last; ++z) {
    for (int y = 0; y < kBlockSide; ++y) {
      const auto dilated = [&](const std::uint32_t(&rows)[kSide][kSide],
                               const std::vector<Run>& runs) {
        std::uint32_t bits = 0;
        for (const Run& r : runs) {
          const std::uint32_t source = rows[z + r.dz + kMaxRadius][y + r.dy + kMaxRadius];
          if (source != 0) bits |= widen(source, r.half);
        }
        return bits >> 8;
      };
      const std::uint32_t blocked = any_occupied ? dilated(occupied, occupied_runs_) : 0;
      const std::uint32_t free = row(block.merged.free.data(), y, z);
      put_row(block.blocked, y, z, blocked);
      put_row(block.traversable, y, z,
              free == 0 ? 0 : free & ~blocked & ~dilated(unknown, unknown_runs_));
    }
  }
}

}  // namespace muster::map
