#include "common/dds/mission_clock.h"

#include <rapidcheck.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

using muster::dds::MissionClock;

namespace {

constexpr double kDrivers_s = 50;  // what the drivers' clock is ahead of the monotonic one

MissionClock robot(double monotonic_s = 0) {
  MissionClock clock(false);
  clock.driver_says(kDrivers_s + monotonic_s, monotonic_s);
  return clock;
}

}  // namespace

TEST_CASE("the drivers' first sample sets mission time, later ones correct it gently") {
  MissionClock clock(false);
  CHECK_FALSE(clock.set());
  clock.driver_says(100, 7);
  CHECK(clock.at(7) == 100);
  clock.driver_says(101.05, 8);
  CHECK(clock.at(8) == 101);
  CHECK(clock.at(9) == Approx(102.01));
}

TEST_CASE("a robot that hears the station comes to its time, and its time never runs backwards") {
  for (const double station_s : {kDrivers_s + 3, kDrivers_s - 3}) {
    MissionClock clock = robot();
    double last_s = clock.at(0);
    for (int i = 1; i < 1200; ++i) {
      const double now_s = 0.1 * i;
      clock.beacon_says(0, station_s + now_s, now_s);
      clock.driver_says(kDrivers_s + now_s, now_s);  // outranked
      CHECK(clock.at(now_s) > last_s);
      last_s = clock.at(now_s);
    }
    CHECK(clock.at(120) == Approx(station_s + 120).margin(1e-6));
    CHECK(clock.stratum(120) == 1);
  }
}

TEST_CASE("beacons that were delayed do not hold the clock back") {
  MissionClock clock = robot();
  for (int i = 1; i < 600; ++i) {
    const double now_s = 0.1 * i, delay_s = i % 7 == 0 ? 0.002 : 0.08;
    clock.beacon_says(0, kDrivers_s + now_s - delay_s, now_s);
  }
  CHECK(clock.at(60) == Approx(kDrivers_s + 60).margin(0.003));
}

TEST_CASE("nobody follows a clock that is as far from the station as the own one") {
  MissionClock clock = robot();
  clock.beacon_says(3, kDrivers_s + 1, 1);
  CHECK(clock.stratum(1) == 4);
  const double before_s = clock.at(2);
  clock.beacon_says(4, kDrivers_s + 90, 2);
  CHECK(clock.at(2) == before_s);
  MissionClock station(true);
  station.driver_says(10, 0);
  station.beacon_says(0, 99, 1);
  CHECK(station.at(1) == 11);
}

TEST_CASE("out of the station's hearing a robot keeps its distance to the drivers' clock") {
  MissionClock clock = robot();
  clock.beacon_says(0, kDrivers_s + 61, 1);
  CHECK(clock.at(1) == kDrivers_s + 61);
  for (int i = 2; i < 100; ++i) clock.driver_says(kDrivers_s + i + 0.2, i);
  CHECK(clock.at(100) == Approx(kDrivers_s + 160.2).margin(1e-6));
}

TEST_CASE("who is far behind is right at once, who is far ahead runs at half speed until it is") {
  MissionClock behind = robot(), ahead = robot();
  behind.beacon_says(0, kDrivers_s + 70, 10);
  CHECK(behind.at(10) == kDrivers_s + 70);
  CHECK(behind.stratum(10) == 1);
  ahead.beacon_says(0, kDrivers_s - 50, 10);
  CHECK(ahead.at(10) == kDrivers_s + 10);
  CHECK(ahead.stratum(10) == MissionClock::kUnknownStratum);
  CHECK(ahead.bound_s(10) > 60);
  CHECK(ahead.at(110) == Approx(kDrivers_s + 60));
  CHECK(ahead.at(200) == Approx(kDrivers_s + 140));
  CHECK(ahead.stratum(200) == 1);
  CHECK(ahead.bound_s(200) < 0.3);
}

TEST_CASE("what is asked of the drivers for a mission time, they do when it comes") {
  for (const double off_s : {-20.0, -0.2, 0.0, 0.3, 20.0}) {
    MissionClock clock = robot();
    clock.beacon_says(0, kDrivers_s + off_s + 5, 5);
    for (const double later_s : {0.1, 1.0, 7.0, 30.0, 60.0, 200.0}) {
      const double driver_s = clock.driver_when(clock.at(5 + later_s), 5);
      CHECK(driver_s - kDrivers_s == Approx(5 + later_s).margin(1e-6));
    }
  }
}

TEST_CASE("a clock that is set anew follows whoever follows somebody, a station's too") {
  MissionClock one = robot(), station(true);
  station.driver_says(kDrivers_s, 0);
  one.beacon_says(0, kDrivers_s + 1, 1);
  for (MissionClock* skewed : {&one, &station}) {
    skewed->skew(60, 2);
    CHECK(skewed->at(2) == Approx(kDrivers_s + 62));
    CHECK(skewed->stratum(2) == MissionClock::kUnknownStratum);
    skewed->beacon_says(2, kDrivers_s + 3, 3);
    CHECK(skewed->at(200) == Approx(kDrivers_s + 200).margin(1e-6));
  }
  CHECK(one.stratum(200) == 3);
  CHECK(station.stratum(200) == 0);
}

namespace {

/// A robot of the fleet below: its monotonic clock drifts.
struct Quartz {
  MissionClock clock;
  double speed = 1;  ///< monotonic seconds per true second
  double last_s = -1e9;

  double monotonic(double true_s) const { return speed * true_s; }
  /// Checks that it runs.
  double read(double true_s) {
    const double now_s = clock.at(monotonic(true_s));
    RC_ASSERT(now_s > last_s);
    last_s = now_s;
    return now_s;
  }
  std::pair<std::uint32_t, double> says(double true_s) {
    return {clock.stratum(monotonic(true_s)), read(true_s)};
  }
  void hear(const std::pair<std::uint32_t, double>& beacon, double true_s) {
    clock.beacon_says(beacon.first, beacon.second, monotonic(true_s));
  }
};

}  // namespace

TEST_CASE("whatever clocks say and in whatever order they meet, all come to the station's time") {
  CHECK(rc::check("clocks run, and are within their bounds after a chain of contacts", [] {
    const auto between = [](int low, int high) { return *rc::gen::inRange(low, high + 1); };
    const int robots = between(2, 5);
    std::vector<Quartz> fleet;
    for (int i = 0; i < robots; ++i) {
      fleet.push_back({MissionClock(i == 0), 1 + 1e-6 * between(-100, 100), -1e9});
      fleet[i].clock.driver_says(i == 0 ? 1000 : 1000 + between(-60, 60), 0);
    }
    double now_s = 0;
    const auto meet = [&](int a, int b, int seconds) {
      for (int tick = 0; tick < 10 * seconds; ++tick) {
        const double late_s = 0.01 * between(0, 19);
        now_s += 0.1;
        const auto of_a = fleet[a].says(now_s), of_b = fleet[b].says(now_s);
        fleet[b].hear(of_a, now_s + late_s);
        fleet[a].hear(of_b, now_s + late_s);
        now_s += 0.2;
        for (Quartz& robot : fleet) robot.read(now_s);
      }
    };
    for (int i = between(0, 4); i > 0; --i) {
      const int a = between(0, robots - 1), b = between(0, robots - 1);
      if (a != b) meet(a, b, between(1, 5));
      now_s += between(0, 600);
      if (*rc::gen::arbitrary<bool>()) {
        const int who = between(1, robots - 1);
        fleet[who].clock.skew(between(-60, 60), fleet[who].monotonic(now_s));
      }
    }
    for (int i = 1; i < robots; ++i) meet(i - 1, i, 100);
    const double station_s = fleet[0].clock.at(fleet[0].monotonic(now_s));
    double bound_s = 0;
    for (Quartz& robot : fleet) {
      const double own_s = robot.monotonic(now_s), bound_of_one_s = robot.clock.bound_s(own_s);
      bound_s += bound_of_one_s;
      RC_ASSERT(std::abs(robot.clock.at(own_s) - station_s) <= bound_s + 1e-3);
      RC_ASSERT(bound_of_one_s < 2);
    }
  }));
}
