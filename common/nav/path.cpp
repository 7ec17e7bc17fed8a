#include "common/nav/path_finder.h"

namespace muster::nav {

double Path::length_m() const {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

}  // namespace muster::nav
