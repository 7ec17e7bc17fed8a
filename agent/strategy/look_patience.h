#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/geometry/pose.h"

namespace muster::agent {

/// When to stop looking at surfaces. Every look costs the same, and places at which something is
/// sighted come ever more rarely: when looks have shown no new one for half as long as it took to
/// see all there are, what is left are voxels that hardly any pose shows, or only noise.
///
/// Places are counted as they are sighted, not as areas are known: an explorer whose looks are lost
/// knows its areas, but not which surfaces it has looked at, and sees the places again on its way.
class LookPatience {
 public:
  /// One more look, and where it sighted something.
  void look(const std::vector<Vec3>& sighted) {
    ++looks_;
    for (const Vec3& p : sighted) {
      const bool known = std::any_of(places_.begin(), places_.end(),
                                     [&](const Vec3& q) { return (p - q).norm() < kSamePlace_m; });
      if (known) continue;
      places_.push_back(p);
      last_news_ = looks_;
    }
  }
  bool exhausted() const {
    const auto share = static_cast<std::uint64_t>(kShare * static_cast<double>(last_news_));
    return looks_ - last_news_ > std::max(kLeast, share);
  }

 private:
  static constexpr std::uint64_t kLeast = 60;
  static constexpr double kShare = 0.5;
  static constexpr double kSamePlace_m = 0.8;  // what is only noise is no news

  std::vector<Vec3> places_;
  std::uint64_t looks_ = 0;
  std::uint64_t last_news_ = 0;  // looks when the last place was found
};

}  // namespace muster::agent
