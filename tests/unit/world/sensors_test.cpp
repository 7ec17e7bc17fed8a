#include "commsim/world/sensors.h"

#include <catch2/catch.hpp>

#include "tests/unit/world/fixtures.h"

using namespace muster;
using namespace muster::world;
using namespace muster::world::testing;

namespace {

const RobotId kSelf{1};
const Pose kPose{{0, 0, 2}, 0};

Mesh wall_at(double x) {
  Mesh mesh = ground();
  add_wall(mesh, x, -10, 10, 6);
  return mesh;
}

}  // namespace

TEST_CASE("a depth camera measures a wall within its noise bounds and nothing beyond its range") {
  const Scene scene(wall_at(3));
  const Surroundings around(scene, {});
  const mission::Vehicle vehicle;
  const mission::SensingConfig noise;
  Random random(1, kSelf, "test");
  const mission::Scan scan =
      RangeSensor::depth_camera(vehicle).sweep(around, kSelf, kPose, noise, random);
  REQUIRE(scan.range_mm.size() == 48 * 31);
  int returned = 0;
  for (std::uint32_t r = 0; r < scan.rows; ++r) {
    for (std::uint32_t c = 0; c < scan.columns; ++c) {
      const double az = scan.hfov_rad * (0.5 - (c + 0.5) / scan.columns);
      const double el = scan.vfov_rad * ((r + 0.5) / scan.rows - 0.5);
      const Vec3 d = ray_direction(0, 0, az, el);
      double truth = 3 / d.x();
      if (d.z() < 0) truth = std::min(truth, -2 / d.z());
      const std::uint16_t mm = scan.range_mm[r * scan.columns + c];
      CHECK(mm <= 5000);
      if (truth > 5) {
        CHECK(mm == mission::kNoReturn);
      } else {
        ++returned;
        CHECK(std::abs(mm / 1000.0 - truth) <= 0.02 + 0.05 * truth + 0.001);
      }
    }
  }
  CHECK(returned > 1000);
}

TEST_CASE("another robot's body blocks rays and appears in scans, one's own does not") {
  const Scene scene(wall_at(4));
  const Surroundings around(scene, {{kSelf, kPose.p, 0.25}, {RobotId{2}, {2, 0, 2}, 0.25}});
  mission::SensingConfig noise;
  noise.depth_noise = noise.range_noise_m = 0;
  Random random(1, kSelf, "test");
  mission::Vehicle vehicle;
  vehicle.columns = vehicle.rows = 31;
  const mission::Scan scan =
      RangeSensor::depth_camera(vehicle).sweep(around, kSelf, kPose, noise, random);
  CHECK(scan.range_mm[15 * 31 + 15] == 1750);
  CHECK(scan.range_mm[15 * 31 + 5] > 4000);
}

TEST_CASE("a lidar sweeps a full turn at its own height") {
  const Scene scene(wall_at(3));
  const Surroundings around(scene, {});
  mission::Vehicle vehicle = rover(1, {0, 0, 1}).vehicle;
  Random random(1, kSelf, "test");
  const mission::Scan scan = RangeSensor::lidar(vehicle).sweep(around, kSelf, kPose, {}, random);
  REQUIRE(scan.range_mm.size() == 360);
  CHECK(scan.range_mm[179] == Approx(3000).margin(200));
  CHECK(scan.range_mm[0] == mission::kNoReturn);
}

TEST_CASE("sighting needs range, field of view and line of sight") {
  Mesh mesh = wall_at(3);
  add_wall(mesh, 2, 0.5, 2, 4);
  const Scene scene(mesh);
  const Surroundings around(scene, {{RobotId{2}, {1.5, -1, 2}, 0.25}});
  const Vec3 front(-1, 0, 0);
  const std::vector<Feature> spots = {
      feature(0, {3, 0, 2}, front),            // seen
      feature(1, {3, 1.5, 2}, front),          // behind the small wall
      feature(2, {3, -2, 2}, front),           // behind the other robot
      feature(3, {3, 0, 5.9}, front),          // above the field of view
      feature(4, {3, 0.2, 2}, -front),         // on the back of the wall
      feature(5, {3, -0.5, 2}, front, false),  // a decoy, seen like a true one
  };
  mission::SensingConfig sensing;
  sensing.sighting_probability = 1;
  Random random(1, kSelf, "test");
  const Look look = look_for_spots(around, kSelf, kPose, {}, spots, sensing, random);
  CHECK(look.reported == std::vector<std::size_t>{0, 5});
  CHECK(look.sightings.seen.size() == 2);
}

TEST_CASE("sightings come with probability 0.9 and σ 0.1 m, and their order tells nothing") {
  const Scene scene(wall_at(3));
  const Surroundings around(scene, {});
  const std::vector<Feature> spots = {feature(0, {3, 1, 2}, {-1, 0, 0}),
                                      feature(1, {3, -1, 2}, {-1, 0, 0}, false)};
  Random random(1, kSelf, "test");
  int seen = 0;
  double square = 0;
  for (int i = 0; i < 2000; ++i) {
    const Look look = look_for_spots(around, kSelf, kPose, {}, spots, {}, random);
    for (const mission::Sighting& s : look.sightings.seen) {
      ++seen;
      square += (s.position - spots[s.position.y() > 0 ? 0 : 1].position).squaredNorm();
    }
    if (look.sightings.seen.size() == 2) {
      CHECK(look.sightings.seen[0].position.x() <= look.sightings.seen[1].position.x());
    }
  }
  CHECK(seen / 4000.0 == Approx(0.9).margin(0.02));
  CHECK(std::sqrt(square / seen / 3) == Approx(0.1).margin(0.005));
}
