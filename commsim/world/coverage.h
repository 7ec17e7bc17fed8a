#pragma once

#include <map>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "common/map/voxel_map.h"
#include "common/mission/mission.h"
#include "common/store/record.h"

namespace muster::world {

/// `map_coverage` of RULES.md, from the map records that reached the station: of the surface voxels
/// that count, the share that some record calls occupied, there or in one of the six voxels next to
/// it (range noise moves a surface by one). With no surfaces that count: the share of the boxes'
/// voxels that are known at all. Once covered, covered, as long as the station's disk is.
class Coverage {
 public:
  /// `surface`: centres of the observable surface voxels.
  Coverage(const mission::Mission& mission, const std::vector<Vec3>& surface);

  /// A record of class kMap. Throws BadInput when its bytes are no blocks.
  void received(const store::Record& record);
  double share() const;
  /// The station holds nothing any more.
  void station_lost_all();
  std::size_t total() const { return total_; }

 private:
  void occupied(map::VoxelKey k);
  void known(map::VoxelKey k);

  double resolution_m_;
  std::vector<Box> boxes_;
  bool by_volume_;
  std::unordered_map<std::uint64_t, bool> surface_;  ///< looked up only, never walked
  std::unordered_set<std::uint64_t> known_;
  std::map<std::pair<RobotId, std::uint64_t>, std::pair<std::uint64_t, std::uint64_t>> newest_;
  std::size_t total_ = 0, covered_ = 0;
};

/// A voxel as one number, 21 bits per axis.
std::uint64_t voxel_number(map::VoxelKey k);
map::VoxelKey voxel_at(const Vec3& p, double resolution_m);

}  // namespace muster::world
