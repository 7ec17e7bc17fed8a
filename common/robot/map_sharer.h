#pragma once

#include <set>
#include <vector>

#include "common/robot/knowledge.h"

namespace muster::robot {

/// Turns what the own map has newly seen into map records: only when somebody is there to hear
/// them, and only what nobody has said before (DESIGN "Records", Map).
///
/// On meeting somebody all news are told at once; in company, every 5 s, robots taking turns, so
/// that of two who see the same the second has nothing left to say. A few voxels wait for more, up
/// to half a minute.
class MapSharer {
 public:
  void step(Knowledge& knowledge);

 private:
  void look(const Knowledge& knowledge);
  std::vector<map::SaidBlock> take_news(const Knowledge& knowledge);
  void tell(Knowledge& knowledge, std::span<const map::SaidBlock> news);

  std::uint64_t cursor_ = 0;
  std::set<map::BlockKey> changed_;  // since they were last looked at for news
  std::set<RobotId> company_;
  SimTime looked_, told_;
  bool telling_ = false;
};

}  // namespace muster::robot
