#pragma once

#include <chrono>
#include <thread>

#include "common/core/time.h"

namespace muster::world {

/// Holds a run back to `speed` times real time (0: as fast as possible). Waits only; decides
/// nothing.
class Pacer {
 public:
  explicit Pacer(double speed) : speed_(speed), start_(std::chrono::steady_clock::now()) {}

  void wait_until(SimTime now) const {
    if (speed_ <= 0) return;
    std::this_thread::sleep_until(start_ +
                                  std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                      std::chrono::duration<double>(now.s() / speed_)));
  }

 private:
  double speed_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace muster::world
