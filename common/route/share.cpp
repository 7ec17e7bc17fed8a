#include "common/route/share.h"

#include <algorithm>

namespace muster::route {
namespace {

constexpr double kGain = 1e-9;

}  // namespace

std::vector<std::uint32_t> share_inspectors(std::uint32_t inspectors,
                                            const std::vector<double>& volumes_m3) {
  const std::size_t n = volumes_m3.size();
  std::vector<std::uint32_t> share(n, 0);
  if (n == 0) return share;
  double total = 0;
  for (const double v : volumes_m3) total += std::max(v, 0.0);

  std::vector<double> quota(n);
  std::uint32_t left = inspectors;
  for (std::size_t i = 0; i < n; ++i) {
    const double part = total > 0 ? std::max(volumes_m3[i], 0.0) / total : 1.0 / double(n);
    quota[i] = part * inspectors;
    share[i] = std::min(left, static_cast<std::uint32_t>(quota[i] + kGain));  // floor, as in (14)
    left -= share[i];
  }
  // (14) alone leaves inspectors over: they go to the largest remainders.
  std::vector<std::size_t> by_remainder(n);
  for (std::size_t i = 0; i < n; ++i) by_remainder[i] = i;
  std::stable_sort(by_remainder.begin(), by_remainder.end(), [&](auto a, auto b) {
    return quota[a] - share[a] > quota[b] - share[b] + kGain;
  });
  for (std::size_t i = 0; left > 0; i = (i + 1) % n, --left) ++share[by_remainder[i]];

  // A region without an inspector takes one from the region that has most above its quota.
  for (std::size_t i = 0; i < n; ++i) {
    if (share[i] > 0) continue;
    std::size_t giver = n;
    for (std::size_t j = 0; j < n; ++j) {
      if (share[j] < 2) continue;
      if (giver == n || share[j] - quota[j] > share[giver] - quota[giver] + kGain) giver = j;
    }
    if (giver == n) break;
    --share[giver];
    ++share[i];
  }
  return share;
}

}  // namespace muster::route
