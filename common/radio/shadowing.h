#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/geometry/pose.h"

namespace muster::radio {

/// How much better or worse than on average a signal is between two places, in σ: a smooth random
/// field over both ends (six dimensions), normal with mean 0 and variance 1, the same in both
/// directions to the last bit, and decided by the seed alone, so that whoever comes back to a place
/// finds it as it was.
///
/// A sum of plane waves over both ends (Jaeckel et al., "Efficient sum-of-sinusoids based spatial
/// consistency for the 3GPP new-radio channel model", 2018): no grid to store, the same cost
/// anywhere. Its correlation falls as exp(−(r/r₀)²), smooth at 0, unlike Gudmundson's exp(−r/r₀),
/// which agrees with it at r₀ but would cross any level infinitely often on the way.
class Shadowing {
 public:
  /// `distance_m` > 0: r₀, how far one end moves until the correlation is 1/e.
  Shadowing(std::uint64_t seed, double distance_m);

  double between(const Vec3& a, const Vec3& b) const;

 private:
  struct Wave {
    Vec3 k_near, k_far;  ///< rad/m at one end and at the other
    double phase_rad;
  };
  double distance_m_;
  std::vector<Wave> waves_;
};

}  // namespace muster::radio
