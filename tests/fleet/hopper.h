#pragma once

#include <memory>

#include "common/core/hash.h"
#include "common/mission/mission.h"
#include "common/mission/process.h"

namespace muster::test {

/// The simplest robot that uses everything a shell moves: it hops up and down over its start, sends
/// beacons and, now and then, a record, and folds every byte that reaches it into its trace. Two
/// transports that give hoppers the same trace move the same bytes at the same ticks.
std::unique_ptr<mission::Process> make_hopper(const mission::Mission& mission, RobotId id,
                                              std::uint64_t epoch);

}  // namespace muster::test
