#pragma once

#include <cstdint>
#include <string_view>

#include "common/core/ids.h"

namespace muster {

/// A seeded stream of random numbers (xoshiro256**). Streams with different (seed, robot, purpose)
/// are independent, so that a draw added in one place changes no other (DESIGN "Time and
/// determinism"). Own distributions: the standard's differ by library.
class Random {
 public:
  Random(std::uint64_t mission_seed, RobotId robot, std::string_view purpose);

  std::uint64_t next();
  /// Uniform in [0, 1).
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in {0 … n−1}; n > 0.
  std::uint64_t below(std::uint64_t n);
  /// Standard normal.
  double normal();
  bool chance(double p) { return uniform() < p; }

 private:
  std::uint64_t s_[4];
};

}  // namespace muster
