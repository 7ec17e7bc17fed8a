#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace muster::agent {

/// When to stop looking at surfaces. Every look costs the same, and the places of areas come ever
/// more rarely: when looks have found no new one for half as long as it took to find all there are,
/// what is left are voxels that hardly any pose shows, or only noise.
class LookPatience {
 public:
  /// Looks taken so far, and places of areas that are known by now.
  void weigh(std::uint64_t looks, std::size_t places) {
    if (places > places_) last_news_ = looks;
    places_ = places;
    const auto patience =
        std::max(kLeast, static_cast<std::uint64_t>(kShare * static_cast<double>(last_news_)));
    exhausted_ = looks - last_news_ > patience;
  }
  bool exhausted() const { return exhausted_; }

 private:
  static constexpr std::uint64_t kLeast = 60;
  static constexpr double kShare = 0.5;

  std::size_t places_ = 0;
  std::uint64_t last_news_ = 0;  // looks when the last place was found
  bool exhausted_ = false;
};

}  // namespace muster::agent
