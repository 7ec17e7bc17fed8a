#pragma once

#include <chrono>
#include <vector>

#include "common/mission/messages.h"

namespace muster::robot {

/// Adds the wall-clock time of its scope to a list: for reports only, never for a decision.
class Stopwatch {
 public:
  Stopwatch(std::vector<mission::PlanningTime>& into, mission::PlanningStep step)
      : into_(into), step_(step), begin_(std::chrono::steady_clock::now()) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() {
    const std::chrono::duration<float, std::milli> took = std::chrono::steady_clock::now() - begin_;
    into_.push_back({step_, took.count()});
  }

 private:
  std::vector<mission::PlanningTime>& into_;
  mission::PlanningStep step_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace muster::robot
