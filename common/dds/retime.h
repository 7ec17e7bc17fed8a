#pragma once

#include <functional>

#include "common/mission/messages.h"

/// Times in messages from one clock to another, on board, where both are known: drivers and fleet
/// need not agree on what time it is. What does not decode stays as it is: whoever reads it says
/// so.
namespace muster::dds {

using Retime = std::function<SimTime(SimTime)>;

/// Of a driver's sample: when it was taken.
void retime_sample(mission::Message& sample, const Retime& retime);
/// Of a command to the drivers: when to be where.
void retime_command(mission::Message& command, const Retime& retime);
/// Of a beacon: when its sender will be where, and what time it says it is.
void retime_beacon(mission::Message& beacon, const Retime& retime);
/// Of one's own beacon: the clock's stratum.
void set_stratum(mission::Message& beacon, std::uint32_t stratum);

}  // namespace muster::dds
