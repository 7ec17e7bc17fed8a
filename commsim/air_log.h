#pragma once

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "common/core/ids.h"
#include "common/core/time.h"
#include "commsim/ether.h"

namespace muster::commsim {

/// Who heard whom, when, how much, and what was dropped and why: `air.csv`, for `muster air`. Off
/// the trace.
///
///     t_s,from,to,heard,heard_bytes,dropped_bytes,range,wall,dead,scripted,loss,airtime,jam,cut,paused,pose
///     12,2,1,9,4410,0,3,0,0,0,0,0,0,0,0,0
///
/// A row is what became of one robot's messages at another within the 2 s that begin at t_s. In
/// most of them most pairs are out of range: without a message heard or lost there is no row, and
/// its drops are counted in the pair's next row, or in a last one at the end, so that sums are
/// exact.
class AirLog {
 public:
  /// `robots` ascending. Throws Failure when the file cannot be written.
  AirLog(const std::string& path, std::vector<RobotId> robots);

  /// Before what happens at `now`, whose times never go back.
  void advance(SimTime now);
  void heard(std::size_t from, std::size_t to, std::size_t bytes);
  void dropped(std::size_t from, std::size_t to, std::size_t bytes, Drop reason);
  /// Writes what is left; nothing may follow.
  void finish();

 private:
  struct Cell {
    std::uint64_t heard = 0, heard_bytes = 0, dropped_bytes = 0;
    std::array<std::uint64_t, kDrops> drops{};
    bool remarkable = false;  ///< more than silence
  };
  Cell& cell(std::size_t from, std::size_t to) { return cells_[from * robots_.size() + to]; }
  void write(bool all);

  std::ofstream file_;
  std::vector<RobotId> robots_;
  std::vector<Cell> cells_;
  std::int64_t bin_ = 0;
};

}  // namespace muster::commsim
