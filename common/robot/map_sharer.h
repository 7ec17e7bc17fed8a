#pragma once

#include <map>

#include "common/robot/knowledge.h"

namespace muster::robot {

/// Turns what the own map has newly seen into map records: only when somebody is there to hear
/// them, a block at most every 5 s, and a bounded number per tick (DESIGN "Records", Map).
class MapSharer {
 public:
  void step(Knowledge& knowledge);
  /// Blocks that changed and could be published now, but are not yet.
  bool behind() const { return behind_; }

 private:
  std::uint64_t cursor_ = 0;
  std::map<map::BlockKey, bool> pending_;
  std::map<map::BlockKey, SimTime> published_;
  SimTime looked_;
  bool met_ = false;
  bool behind_ = false;
};

}  // namespace muster::robot
