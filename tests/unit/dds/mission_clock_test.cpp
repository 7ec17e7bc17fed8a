#include "common/dds/mission_clock.h"

#include <catch2/catch.hpp>

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
  CHECK(clock.at(8) == Approx(101.01));
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
    CHECK(clock.stratum() == 1);
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
  CHECK(clock.stratum() == 4);
  const double before_s = clock.at(2);
  clock.beacon_says(4, kDrivers_s + 90, 2);
  CHECK(clock.at(2) == before_s);
  MissionClock station(true);
  station.driver_says(10, 0);
  station.beacon_says(0, 99, 1);
  CHECK(station.at(1) == 11);
}

TEST_CASE("after the station has fallen silent the drivers' clock counts again") {
  MissionClock clock = robot();
  clock.beacon_says(0, kDrivers_s + 1, 1);
  for (int i = 2; i < 100; ++i) clock.driver_says(kDrivers_s + i + 0.2, i);
  CHECK(clock.at(100) == Approx(kDrivers_s + 100.2).margin(1e-6));
}
