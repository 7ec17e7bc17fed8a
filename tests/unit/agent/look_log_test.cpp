#include "agent/strategy/look_log.h"

#include <catch2/catch.hpp>

#include "common/core/random.h"

using namespace muster;
using agent::second_source;

namespace {

std::vector<Vec3> around(const Vec3& p, std::size_t n, Random& random) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    points.push_back(p + 0.1 * Vec3(x, y, z));
  }
  return points;
}

}  // namespace

TEST_CASE("the sightings of one source are not told apart") {
  Random random(1, RobotId{1}, "one source");
  for (const std::size_t n : {1u, 2u, 5u, 20u, 100u, 300u}) {
    for (int run = 0; run < 30; ++run) {
      const std::vector<Vec3> points = around({1, 2, 3}, n, random);
      CHECK(second_source(points, 0.1, Vec3(1, 2, 3)).empty());
      CHECK(second_source(points, 0.1, std::nullopt).empty());
    }
  }
}

TEST_CASE("a second source shows in about a dozen sightings, and which are its") {
  Random random(2, RobotId{1}, "two sources");
  int found_known = 0, found_fitted = 0;
  std::size_t right = 0, all = 0;
  for (int run = 0; run < 50; ++run) {
    std::vector<Vec3> points = around({1, 2, 3}, 12, random);
    const std::vector<Vec3> others = around({1.35, 2, 3}, 12, random);
    points.insert(points.end(), others.begin(), others.end());
    const auto group = second_source(points, 0.1, Vec3(1, 2, 3));
    found_known += !group.empty();
    found_fitted += !second_source(points, 0.1, std::nullopt).empty();
    for (const std::size_t i : group) right += i >= 12, ++all;
  }
  CHECK(found_known > 45);
  CHECK(found_fitted > 40);
  CHECK(static_cast<double>(right) > 0.9 * static_cast<double>(all));
}
