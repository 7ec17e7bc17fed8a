#include "common/radio/channel.h"

#include <catch2/catch.hpp>
#include <limits>
#include <stdexcept>

using namespace muster;
using namespace muster::radio;

namespace {

/// A wall in the plane x = 0.
bool beside_the_wall(const Vec3& a, const Vec3& b) { return a.x() * b.x() > 0; }

constexpr RobotId kA{1}, kB{2}, kC{3};

}  // namespace

TEST_CASE("a radio reaches as far as its range, and not through walls") {
  const Channel channel({5, true, {}}, beside_the_wall);
  CHECK(channel.between({1, 0, 0}, {6, 0, 0}) == Link::kUp);
  CHECK(channel.between({1, 0, 0}, {6.001, 0, 0}) == Link::kRange);
  CHECK(channel.between({1, 0, 0}, {-1, 0, 0}) == Link::kWall);
  CHECK(channel.between({1, 0, 0}, {-9, 0, 0}) == Link::kRange);
}

TEST_CASE("without line of sight in the mission walls do not matter") {
  const Channel channel({5, false, {}}, nullptr);
  CHECK(channel.between({1, 0, 0}, {-1, 0, 0}) == Link::kUp);
}

TEST_CASE("a pair that is always on hears each other anywhere") {
  const Channel channel({5, true, {{kB, kA}}}, beside_the_wall);
  CHECK(channel.between(kA, {-100, 0, 0}, kB, {100, 0, 0}) == Link::kUp);
  CHECK(channel.between(kB, {-100, 0, 0}, kA, {100, 0, 0}) == Link::kUp);
  CHECK(channel.between(kA, {-100, 0, 0}, kC, {100, 0, 0}) == Link::kRange);
}

TEST_CASE("both sides of a link ask for the same ray") {
  int asked = 0;
  const Channel channel({5, true, {}}, [&](const Vec3& a, const Vec3& b) {
    ++asked;
    CHECK(a.isApprox(Vec3(1, 2, 3)));
    CHECK(b.isApprox(Vec3(2, 1, 3)));
    return true;
  });
  channel.between(kA, {1, 2, 3}, kB, {2, 1, 3});
  channel.between(kB, {2, 1, 3}, kA, {1, 2, 3});
  channel.between({2, 1, 3}, {1, 2, 3});
  CHECK(asked == 3);
}

TEST_CASE("a radio out of reason is refused, and nowhere is out of range") {
  CHECK_THROWS_AS(Channel({0, false, {}}, nullptr), std::invalid_argument);
  CHECK_THROWS_AS(Channel({std::numeric_limits<double>::quiet_NaN(), false, {}}, nullptr),
                  std::invalid_argument);
  CHECK_THROWS_AS(Channel({5, true, {}}, nullptr), std::invalid_argument);
  const Channel channel({5, false, {}}, nullptr);
  CHECK(channel.between({std::numeric_limits<double>::quiet_NaN(), 0, 0}, {0, 0, 0}) ==
        Link::kRange);
}
