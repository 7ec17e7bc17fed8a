#include "common/route/share.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "common/core/random.h"

using namespace muster;
using namespace muster::route;

TEST_CASE("inspectors are shared by volume, none is left over, and every region gets one") {
  CHECK(share_inspectors(4, {1, 1}) == std::vector<std::uint32_t>{2, 2});
  CHECK(share_inspectors(5, {3, 1}) == std::vector<std::uint32_t>{4, 1});
  CHECK(share_inspectors(3, {100, 1, 1}) == std::vector<std::uint32_t>{1, 1, 1});
  CHECK(share_inspectors(10, {90, 5, 5}) == std::vector<std::uint32_t>{8, 1, 1});
  CHECK(share_inspectors(1, {1, 5, 2}) == std::vector<std::uint32_t>{0, 1, 0});
  CHECK(share_inspectors(3, {0, 0}) == std::vector<std::uint32_t>{2, 1});
  CHECK(share_inspectors(3, {}).empty());
  Random random(6, RobotId{0}, "share");
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> volumes(1 + random.below(8));
    for (double& v : volumes) v = random.uniform(1, 1000);
    const auto inspectors = static_cast<std::uint32_t>(random.below(50));
    const auto share = share_inspectors(inspectors, volumes);
    CHECK(std::accumulate(share.begin(), share.end(), 0u) == inspectors);
    if (inspectors >= volumes.size()) CHECK(*std::min_element(share.begin(), share.end()) >= 1);
  }
}
