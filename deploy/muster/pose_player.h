#pragma once

#include <chrono>
#include <memory>

#include "common/dds/participant.h"
#include "deploy/muster/pose_log.h"

namespace muster::command {

/// Plays a log of poses as a motion capture would: `kFrames_per_s` frames a second in the topic
/// `truth` of partition `sim`, on this computer.
class PosePlayer {
 public:
  static constexpr double kFrames_per_s = 20;

  PosePlayer(PoseLog log, dds::Vendor vendor, std::uint32_t domain);

  /// The log's first instant is now.
  void start();
  /// Says the frame that is due, if one is. False: the log is over.
  bool play();

 private:
  using Clock = std::chrono::steady_clock;

  PoseLog log_;
  std::unique_ptr<dds::Participant> participant_;
  std::unique_ptr<dds::Writer> writer_;
  Clock::time_point start_;
  std::uint64_t frame_ = 0;
};

}  // namespace muster::command
