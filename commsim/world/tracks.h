#pragma once

#include <cstdint>
#include <string>

#include "common/mission/messages.h"

namespace muster::world {

// Rows of tracks.csv, where robots were, in the mission's frame. `muster report` draws them and
// `muster lab --poses` plays them again. A writer may add columns of its own.
inline constexpr const char* kTrackColumns = "t_s,robot,x,y,z,yaw_rad";
inline constexpr std::uint64_t kTrackEvery = 10;  ///< ticks

/// Without an end of line.
std::string track_row(SimTime now, const mission::TrueState& robot);

}  // namespace muster::world
