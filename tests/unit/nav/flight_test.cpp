#include <catch2/catch.hpp>
#include <ctime>

#include "common/core/random.h"
#include "common/nav/path_finder.h"
#include "common/nav/trajectory.h"
#include "tests/unit/nav/known_map.h"

using namespace muster;
using namespace muster::nav;
using muster::test::below;
using muster::test::KnownMap;

namespace {

KnownMap pillars(Random& random, map::VoxelKey size, int count) {
  KnownMap hall({0, 0, 0}, size);
  for (int i = 0; i < count; ++i) {
    const int x = below(random, size.x - 3), y = below(random, size.y - 3),
              top = 2 + below(random, size.z - 2);
    const bool beam = random.chance(0.4);
    for (int k = 0; k < (beam ? 12 : top); ++k) {
      for (int w = 0; w < 2; ++w) {
        if (beam) {
          if (x + k < size.x) hall.occupy({x + k, y + w, top});
        } else {
          hall.occupy({x + w, y, k});
        }
      }
    }
  }
  return hall;
}

}  // namespace

TEST_CASE(
    "what is planned passes the check, with sharper corners where there is no room to round them") {
  Random random(11, RobotId{0}, "flight");
  const map::VoxelKey size{90, 90, 30};
  auto hall = pillars(random, size, 90);
  const auto& map = hall.map();
  PathFinder finder(map);
  const Limits limits;
  int flights = 0, rounded = 0, sharp = 0;
  double path_s = 0, timing_s = 0, checking_s = 0, flown_s = 0, states = 0;
  for (int i = 0; i < 300; ++i) {
    const auto draw = [&] {
      return Vec3(random.uniform(0.5, 17.5), random.uniform(0.5, 17.5), random.uniform(0.5, 5.5));
    };
    const Vec3 a = draw(), b = draw();
    if (!map.traversable(a) || !map.traversable(b)) continue;
    auto t = std::clock();
    const auto result = finder.find(a, b);
    path_s += double(std::clock() - t) / CLOCKS_PER_SEC;
    if (!result.path) continue;
    ++flights;
    TimingRequest request;
    request.now.p = a;
    request.now.yaw_rad = random.uniform(-3, 3);
    t = std::clock();
    const auto flight = time_path(*result.path, request, limits);
    timing_s += double(std::clock() - t) / CLOCKS_PER_SEC;
    t = std::clock();
    const auto unsafe = check(flight, flight.start(), map, 0.25, {}, {});
    checking_s += double(std::clock() - t) / CLOCKS_PER_SEC;
    flown_s += (flight.end() - flight.start()).s();
    states += double(flight.states().size());
    rounded += !unsafe;
    const auto careful = time_path(*result.path, request, limits, 0.02);
    sharp += !check(careful, careful.start(), map, 0.25, {}, {});
  }
  INFO(flights << " flights, safe with corners rounded by 0.1 m: " << rounded
               << ", by 0.02 m: " << sharp);
  INFO("per flight: path " << 1e3 * path_s / flights << " ms, timing " << 1e6 * timing_s / flights
                           << " us, " << states / flights << " states, " << flown_s / flights
                           << " s; check " << 1e6 * checking_s / flown_s
                           << " us per simulated second");
  CHECK(flights > 100);
  CHECK(rounded >= flights * 95 / 100);
  CHECK(sharp == flights);
}
