#include "common/radio/airtime.h"

#include <rapidcheck.h>

#include <catch2/catch.hpp>
#include <map>
#include <vector>

using namespace muster;
using namespace muster::radio;

namespace {

constexpr RobotId kA{1}, kB{2}, kC{3}, kD{4};
constexpr SimTime kNow{1'000'000};

ChannelConfig slow() {
  return {.bit_rate_mbps = 1, .frame_bytes = 1000, .frame_overhead_us = 100, .queue_ms = 20};
}

}  // namespace

TEST_CASE("bits and frames take their time, and none without a bit rate") {
  CHECK(Airtime(slow()).of(500) == Duration{4'100});
  CHECK(Airtime(slow()).of(2500) == Duration{20'300});
  CHECK(Airtime(slow()).of(0) == Duration{100});
  Airtime unlimited{ChannelConfig{}};
  CHECK_FALSE(unlimited.limited());
  CHECK(unlimited.send(kA, std::vector{kB}, kNow, 1'000'000) == kNow);
}

TEST_CASE("who hears each other takes turns, who does not speaks at once") {
  Airtime air(slow());
  CHECK(air.send(kA, std::vector{kB}, kNow, 500) == kNow + Duration{4'100});
  CHECK(air.send(kB, std::vector{kA}, kNow, 500) == kNow + Duration{8'200});
  CHECK(air.send(kC, std::vector{kD}, kNow, 500) == kNow + Duration{4'100});
  // Free at the sender, but not where it would be heard.
  CHECK(air.send(kC, std::vector{kA}, kNow, 500) == kNow + Duration{12'300});
}

TEST_CASE("what would wait too long is dropped and takes no air") {
  Airtime air(slow());
  CHECK(air.send(kA, std::vector{kB}, kNow, 2500));
  CHECK_FALSE(air.send(kA, std::vector{kB}, kNow, 10));
  CHECK(air.send(kA, std::vector{kB}, kNow + Duration{1'000}, 500) == kNow + Duration{24'400});
}

TEST_CASE("nobody ever has more than one transmission around it, however many are asked for") {
  CHECK(rc::check([] {
    constexpr std::uint32_t kRobots = 6;
    Airtime air(slow());
    std::vector<std::vector<RobotId>> hears(kRobots);
    for (std::uint32_t from = 0; from < kRobots; ++from) {
      for (std::uint32_t to = 0; to < kRobots; ++to) {
        if (to != from && *rc::gen::inRange(0, 2)) hears[from].push_back(RobotId{to});
      }
    }
    std::map<RobotId, SimTime> end_of_last;
    SimTime now{};
    for (int i = 0; i < 100; ++i) {
      now = now + Duration{*rc::gen::inRange(0, 10'000)};
      const auto sender = *rc::gen::inRange<std::uint32_t>(0, kRobots);
      const auto bytes = *rc::gen::inRange<std::size_t>(0, 3000);
      const auto end = air.send(RobotId{sender}, hears[sender], now, bytes);
      if (!end) continue;
      const SimTime start = *end - air.of(bytes);
      RC_ASSERT(start >= now);
      RC_ASSERT(start - now <= Duration::from_s(20e-3));
      std::vector<RobotId> around = hears[sender];
      around.push_back(RobotId{sender});
      for (const RobotId robot : around) {
        RC_ASSERT(start >= end_of_last[robot]);
        end_of_last[robot] = *end;
      }
    }
  }));
}
