#include "common/geometry/box.h"

#include <catch2/catch.hpp>

#include "common/geometry/camera.h"

using namespace muster;

TEST_CASE("a turned box contains what lies along its own axes") {
  const Box box{{10, 0, 0}, {4, 2, 2}, std::numbers::pi / 2};
  CHECK(box.contains({10, 1.9, 0}));
  CHECK_FALSE(box.contains({11.5, 0, 0}));
  CHECK(box.contains({11.5, 0, 0}, 0.6));
  CHECK(box.distance({13, 0, 0}) == Approx(2));
  CHECK(box.closest({13, 0, 0}).isApprox(Vec3(11, 0, 0)));
  CHECK(box.high().isApprox(Vec3(11, 2, 1)));
}

TEST_CASE("a field of view contains exactly the rays that it casts") {
  const FieldOfView fov{std::numbers::pi / 2, std::numbers::pi / 3, 5};
  const Pose sensor{{1, 2, 3}, 0.7};
  const double pitch = -0.4;
  for (double az : {-0.78, 0.0, 0.78}) {
    for (double el : {-0.52, 0.0, 0.52}) {
      CHECK(fov.contains(sensor, pitch,
                         sensor.p + 4.9 * ray_direction(sensor.yaw_rad, pitch, az, el)));
    }
  }
  CHECK_FALSE(
      fov.contains(sensor, pitch, sensor.p + 4.9 * ray_direction(sensor.yaw_rad, pitch, 0.8, 0)));
  CHECK_FALSE(
      fov.contains(sensor, pitch, sensor.p + 4.9 * ray_direction(sensor.yaw_rad, pitch, 0, 0.53)));
  CHECK_FALSE(
      fov.contains(sensor, pitch, sensor.p + 5.1 * ray_direction(sensor.yaw_rad, pitch, 0, 0)));
}
