#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/mission/messages.h"
#include "common/store/journal.h"

namespace muster::mission {

/// What reaches a robot's process in one tick: bus samples and radio messages in (src, n) order.
struct StepInput {
  std::uint64_t tick = 0;
  SimTime now;
  Duration clock_bound{};  ///< how far `now` may be from the station's (dds::MissionClock)
  std::vector<Message> bus;
  std::vector<Message> air;
};

/// What it answers with. Envelopes are numbered by the process itself (`n` counts everything it
/// sent, air and bus alike).
struct StepOutput {
  std::vector<Message> bus;
  std::vector<Message> air;
  std::uint64_t trace = 0;  ///< hash over what it holds (the store's records): a difference shows
                            ///< up in the tick it arose
  bool declares_complete = false;
  Activity activity{};  ///< shown to people and in tracks.csv, never decided upon
  std::vector<PlanningTime>
      planning;  ///< wall-clock cost of planning steps; reported, never decided upon
};

/// What it would cost to send, at once, all that a robot knows of the place.
struct WholeMapBytes {
  std::uint64_t octree = 0;  ///< as OctoMap's binary octree (the data of a `.bt` file)
  std::uint64_t packed = 0;  ///< 2 bits a voxel in blocks of 16³, 64 blocks at a time by zstd
};

/// A robot or station as a pure function of what reaches it: no DDS, threads, clock or globals. The
/// shells (DDS lock-step, DDS field, in-memory) call `step` once per tick and move bytes.
class Process {
 public:
  virtual ~Process() = default;
  virtual RobotId id() const = 0;
  virtual StepOutput step(const StepInput& input) = 0;
  /// Called once before the first step, when what the process acknowledges is to be kept: it goes
  /// on with what the journal holds, and commits to it in every step before it answers.
  virtual void keep(std::unique_ptr<store::Journal>) {}
  /// For comparison, never decided upon.
  virtual WholeMapBytes whole_map_bytes() { return {}; }
  /// Called once after the last step: write files (map.bt, station.db) into `dir`.
  virtual void finish(const std::string& dir) = 0;
};

}  // namespace muster::mission
