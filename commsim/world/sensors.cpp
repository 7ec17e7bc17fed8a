#include "commsim/world/sensors.h"

#include <algorithm>
#include <cmath>

namespace muster::world {
namespace {

double noisy(double distance_m, const mission::SensingConfig& noise, Random& random) {
  double d = distance_m + random.uniform(-noise.range_noise_m, noise.range_noise_m);
  const double bound = noise.depth_noise * distance_m;
  if (bound > 0) d += std::clamp(random.normal() * bound / 3, -bound, bound);
  return d;
}

std::uint16_t to_mm(double distance_m, double range_m) {
  const double mm = std::round(std::clamp(distance_m, 0.001, range_m) * 1000);
  return static_cast<std::uint16_t>(std::min(mm, 65534.0));
}

}  // namespace

RangeSensor::RangeSensor(mission::SensorKind kind, const FieldOfView& view, double pitch_rad,
                         std::uint32_t columns, std::uint32_t rows)
    : kind_(kind), view_(view), pitch_rad_(pitch_rad), columns_(columns), rows_(rows) {
  if (!fitted()) return;
  directions_.reserve(std::size_t{columns} * rows);
  for (std::uint32_t r = 0; r < rows; ++r) {
    const double el = view.vfov_rad * ((r + 0.5) / rows - 0.5);
    for (std::uint32_t c = 0; c < columns; ++c) {
      const double az = view.hfov_rad * (0.5 - (c + 0.5) / columns);
      directions_.push_back(ray_direction(0, pitch_rad, az, el));
    }
  }
}

RangeSensor RangeSensor::depth_camera(const mission::Vehicle& v) {
  return {mission::SensorKind::kDepthCamera, v.camera, v.pitch_rad, v.columns, v.rows};
}

RangeSensor RangeSensor::lidar(const mission::Vehicle& v) {
  return {mission::SensorKind::kLidar2d, v.lidar, 0, v.lidar_columns, 1};
}

mission::Scan RangeSensor::sweep(const Surroundings& around, RobotId self, const Pose& pose,
                                 const mission::SensingConfig& noise, Random& random,
                                 std::vector<Vec3>* ray_ends) const {
  mission::Scan scan;
  scan.sensor = pose;
  scan.pitch_rad = pitch_rad_;
  scan.kind = kind_;
  scan.columns = columns_;
  scan.rows = rows_;
  scan.hfov_rad = static_cast<float>(view_.hfov_rad);
  scan.vfov_rad = static_cast<float>(view_.vfov_rad);
  scan.range_m = static_cast<float>(view_.range_m);
  scan.range_mm.reserve(directions_.size());
  if (ray_ends) ray_ends->clear();

  const std::vector<Body> bodies = around.near(pose.p, view_.range_m, self);
  const double cy = std::cos(pose.yaw_rad), sy = std::sin(pose.yaw_rad);
  for (const Vec3& local : directions_) {
    const Vec3 direction(cy * local.x() - sy * local.y(), sy * local.x() + cy * local.y(),
                         local.z());
    double distance = view_.range_m;
    bool returned = false;
    if (const auto hit = around.scene().cast(pose.p, direction, distance)) {
      distance = hit->distance_m;
      returned = true;
    }
    for (const Body& body : bodies) {
      const auto hit = cast_sphere(pose.p, direction, body);
      if (!hit || *hit > distance) continue;
      distance = *hit;
      returned = true;
    }
    scan.range_mm.push_back(returned ? to_mm(noisy(distance, noise, random), view_.range_m)
                                     : mission::kNoReturn);
    if (ray_ends) ray_ends->push_back(pose.p + direction * distance);
  }
  return scan;
}

Look look_for_spots(const Surroundings& around, RobotId self, const Pose& pose,
                    const mission::Vehicle& vehicle, const std::vector<Feature>& spots,
                    const mission::SensingConfig& sensing, Random& random) {
  Look look;
  look.sightings.sensor = pose;
  look.sightings.pitch_rad = vehicle.pitch_rad;
  FieldOfView view = vehicle.camera;
  view.range_m = sensing.sighting_range_m;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Feature& spot = spots[i];
    if (!view.contains(pose, vehicle.pitch_rad, spot.position)) continue;
    if (!around.sees(pose.p, before_surface(spot.position, spot.normal), self)) continue;
    if (!random.chance(sensing.sighting_probability)) continue;
    mission::Sighting s;
    const double dx = random.normal(), dy = random.normal(), dz = random.normal();
    s.position = spot.position + sensing.sighting_sigma_m * Vec3(dx, dy, dz);
    s.feature_type = spot.type;
    s.priority = spot.priority;
    look.sightings.seen.push_back(s);
    look.reported.push_back(i);
  }
  std::sort(look.sightings.seen.begin(), look.sightings.seen.end(),
            [](const mission::Sighting& a, const mission::Sighting& b) {
              return std::lexicographical_compare(a.position.begin(), a.position.end(),
                                                  b.position.begin(), b.position.end());
            });
  return look;
}

}  // namespace muster::world
