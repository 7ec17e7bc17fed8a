#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/geometry/pose.h"
#include "common/nav/grid.h"

namespace muster::nav {

/// Visits all cells that the straight from `a` to `b` touches, also those it touches only along an
/// edge or at a corner. `a` and `b` are in voxel edges from the grid's corner. Returns false as
/// soon as `visit` does.
template <class Visit>
bool supercover(const Vec3& a, const Vec3& b, Visit visit) {
  constexpr double kTouch =
      1e-7;  // in parameter: crossings this close are one crossing, through an edge or a corner
  const Vec3 d = b - a;
  std::array<int, 3> at, last, way;
  std::array<double, 3> next, per;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    at[k] = static_cast<int>(std::floor(a[i] + 1e-9));
    last[k] = static_cast<int>(std::floor(b[i] + 1e-9));
    way[k] = d[i] > 0 ? 1 : -1;
    const bool still = at[k] == last[k] || std::abs(d[i]) < 1e-12;
    per[k] = still ? std::numeric_limits<double>::infinity() : 1 / std::abs(d[i]);
    next[k] = still ? std::numeric_limits<double>::infinity()
                    : (d[i] > 0 ? at[k] + 1 - a[i] : a[i] - at[k]) * per[k];
  }
  if (!visit(Cell{at[0], at[1], at[2]})) return false;
  while (at != last) {
    const double soonest = std::min({next[0], next[1], next[2]});
    if (soonest > 1 + kTouch) break;
    std::array<bool, 3> crosses{};
    for (std::size_t k = 0; k < 3; ++k)
      crosses[k] = next[k] <= soonest + kTouch && at[k] != last[k];
    if (!crosses[0] && !crosses[1] && !crosses[2]) break;
    // Through an edge or a corner: every cell of the box between is touched.
    for (int part = 1; part < 8; ++part) {
      std::array<int, 3> cell = at;
      bool wanted = true;
      for (std::size_t k = 0; k < 3; ++k) {
        if (!(part >> k & 1)) continue;
        wanted = wanted && crosses[k];
        cell[k] += way[k];
      }
      if (wanted && !visit(Cell{cell[0], cell[1], cell[2]})) return false;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (!crosses[k]) continue;
      at[k] += way[k];
      next[k] = at[k] == last[k] ? std::numeric_limits<double>::infinity() : next[k] + per[k];
    }
  }
  return true;
}

}  // namespace muster::nav
