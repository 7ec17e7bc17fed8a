#include "common/radio/channel.h"

#include <rapidcheck.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "common/radio/path_loss.h"
#include "common/radio/presets.h"

using namespace muster;
using namespace muster::radio;

namespace {

constexpr RobotId kA{1}, kB{2}, kC{3};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A wall in the plane x = 0.
bool beside_the_wall(const Vec3& a, const Vec3& b) { return a.x() * b.x() > 0; }
bool open_air(const Vec3&, const Vec3&) { return true; }

Link link(const Channel& channel, const Vec3& a, const Vec3& b) {
  return channel.hear(kA, a, kB, b).link;
}

ChannelConfig wifi() { return *preset("wifi-5ghz"); }

ChannelConfig without_chance(ChannelConfig c) {
  c.path_loss->shadowing_db = c.path_loss->asymmetry_db = 0;
  return c;
}

rc::Gen<Vec3> anywhere() {
  return rc::gen::map(rc::gen::tuple(rc::gen::inRange(-2000, 2000), rc::gen::inRange(-2000, 2000),
                                     rc::gen::inRange(0, 300)),
                      [](const std::tuple<int, int, int>& t) {
                        const auto [x, y, z] = t;
                        return Vec3(0.1 * x, 0.1 * y, 0.1 * z);
                      });
}

}  // namespace

TEST_CASE("a radio reaches as far as its range, and not through walls") {
  const Channel channel({5, true, {}}, beside_the_wall);
  CHECK(link(channel, {1, 0, 0}, {6, 0, 0}) == Link::kUp);
  CHECK(link(channel, {1, 0, 0}, {6.001, 0, 0}) == Link::kRange);
  CHECK(link(channel, {1, 0, 0}, {-1, 0, 0}) == Link::kWall);
  CHECK(link(channel, {1, 0, 0}, {-9, 0, 0}) == Link::kRange);
}

TEST_CASE("without line of sight in the mission walls do not matter") {
  const Channel channel({5, false, {}}, nullptr);
  CHECK(link(channel, {1, 0, 0}, {-1, 0, 0}) == Link::kUp);
}

TEST_CASE("a pair that is always on hears each other anywhere") {
  const Channel channel({5, true, {{kB, kA}}}, beside_the_wall);
  CHECK(channel.hear(kA, {-100, 0, 0}, kB, {100, 0, 0}).link == Link::kUp);
  CHECK(channel.hear(kB, {-100, 0, 0}, kA, {100, 0, 0}).link == Link::kUp);
  CHECK(channel.hear(kA, {-100, 0, 0}, kC, {100, 0, 0}).link == Link::kRange);
}

TEST_CASE("both sides of a link ask for the same ray") {
  int asked = 0;
  const Channel channel({5, true, {}}, [&](const Vec3& a, const Vec3& b) {
    ++asked;
    CHECK(a.isApprox(Vec3(1, 2, 3)));
    CHECK(b.isApprox(Vec3(2, 1, 3)));
    return true;
  });
  channel.hear(kA, {1, 2, 3}, kB, {2, 1, 3});
  channel.hear(kB, {2, 1, 3}, kA, {1, 2, 3});
  CHECK(asked == 2);
}

TEST_CASE("a radio out of reason is refused, and nowhere is out of range") {
  CHECK_THROWS_AS(Channel({0, false, {}}, nullptr), std::invalid_argument);
  CHECK_THROWS_AS(Channel({kNaN, false, {}}, nullptr), std::invalid_argument);
  CHECK_THROWS_AS(Channel({5, true, {}}, nullptr), std::invalid_argument);
  CHECK_THROWS_AS(Channel(wifi(), nullptr), std::invalid_argument);
  CHECK(link(Channel({5, false, {}}, nullptr), {kNaN, 0, 0}, {0, 0, 0}) == Link::kRange);
  CHECK(link(Channel(wifi(), open_air), {kNaN, 0, 0}, {0, 0, 0}) == Link::kRange);
}

TEST_CASE("a fading radio goes on behind a wall, and pays for each") {
  const ChannelConfig c = without_chance(wifi());
  for (const int walls : {0, 1, 2, 3, 4}) {
    const Channel channel(c, Obstacles{open_air, [&](const Vec3&, const Vec3&) { return walls; }});
    const auto path = channel.path(kA, {0, 0, 0}, kB, {10, 0, 0});
    CHECK(path.signal_dbm == Approx(15 - 47.2 - 21 - 20 * walls));
    CHECK(path.link == (walls < 3 ? Link::kUp : Link::kWall));
  }
  CHECK(link(Channel(c, open_air), {0, 0, 0}, {1e6, 0, 0}) == Link::kRange);
  CHECK(link(Channel(c, beside_the_wall), {-90, 0, 0}, {90, 0, 0}) == Link::kWall);
}

TEST_CASE("shadowing is shared by both directions, what the devices add is not") {
  CHECK(rc::check([] {
    const Vec3 a = *anywhere(), b = *anywhere();
    const auto seed = *rc::gen::arbitrary<std::uint64_t>();
    const Channel channel(wifi(), open_air, seed);
    const auto ab = channel.path(kA, a, kB, b), ba = channel.path(kB, b, kA, a);
    RC_ASSERT(ab.signal_dbm == ba.signal_dbm);
    RC_ASSERT(ab.link == ba.link);
  }));
  int different = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Channel channel(wifi(), open_air, seed);
    const Vec3 a(0, 0, 1), b(100, 0, 1);
    different += channel.hear(kA, a, kB, b).frame_loss != channel.hear(kB, b, kA, a).frame_loss;
  }
  CHECK(different > 15);
}

TEST_CASE("every question has one answer, whatever was asked before") {
  CHECK(rc::check([] {
    const auto places = *rc::gen::container<std::vector<Vec3>>(6, anywhere());
    const Channel one(wifi(), beside_the_wall, 7), other(wifi(), beside_the_wall, 7);
    std::vector<std::pair<Reception, bool>> forth, back;
    const auto ask = [&](const Channel& channel, std::size_t i) {
      const RobotId from{1}, to{static_cast<std::uint32_t>(i + 2)};
      const Reception r = channel.hear(from, places[0], to, places[i]);
      return std::pair(r, r.link == Link::kUp && channel.is_lost(r, from, 42, to, 5000));
    };
    for (std::size_t i = 1; i < places.size(); ++i) forth.push_back(ask(one, i));
    for (std::size_t i = places.size(); i-- > 1;) back.insert(back.begin(), ask(other, i));
    for (std::size_t i = 0; i < forth.size(); ++i) {
      RC_ASSERT(forth[i].first.link == back[i].first.link);
      RC_ASSERT(forth[i].first.frame_loss == back[i].first.frame_loss);
      RC_ASSERT(forth[i].second == back[i].second);
    }
  }));
}

TEST_CASE("a message is lost as often as its frames say, each receiver by its own draw") {
  ChannelConfig c{.range_m = 5, .line_of_sight = false, .loss = 0.2};
  const Channel channel(c, nullptr, 3);
  int lost = 0, both = 0;
  for (std::uint64_t n = 0; n < 20'000; ++n) {
    const bool b = channel.is_lost({Link::kUp, 0}, kA, n, kB, 100);
    lost += b;
    both += b && channel.is_lost({Link::kUp, 0}, kA, n, kC, 100);
  }
  CHECK(lost / 20'000.0 == Approx(0.2).margin(0.01));
  CHECK(both / 20'000.0 == Approx(0.04).margin(0.006));
  CHECK_FALSE(Channel({5, false, {}}, nullptr).is_lost({Link::kUp, 0}, kA, 1, kB, 100));
}

TEST_CASE("who moves a step keeps its links, who crosses the site may not") {
  const Channel channel(wifi(), open_air, 11);
  double near = 0, far = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 a(0, 0, 1), b(60 + 0.3 * i, 3.0 * i, 2);
    const double here = channel.path(kA, a, kB, b).signal_dbm;
    const double mean_here = open_signal_dbm(*wifi().path_loss, (a - b).norm());
    for (const double step_m : {0.2, 40.0}) {
      const Vec3 there = b + Vec3(0, step_m, 0);
      const double shadow = channel.path(kA, a, kB, there).signal_dbm -
                            open_signal_dbm(*wifi().path_loss, (a - there).norm());
      (step_m < 1 ? near : far) += std::abs(shadow - (here - mean_here));
    }
  }
  CHECK(near / 200 < 0.3);
  CHECK(far / 200 > 2);
}
