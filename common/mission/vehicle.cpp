#include <filesystem>

#include "common/mission/mission.h"
#include "common/mission/reading.h"

namespace muster::mission {
namespace {

void read_field_of_view(YamlMap map, FieldOfView& fov, std::uint32_t& columns,
                        std::uint32_t* rows) {
  read_degrees(map, "hfov_deg", fov.hfov_rad, 1, 360);
  if (rows) read_degrees(map, "vfov_deg", fov.vfov_rad, 1, 170);
  read_at_least(map, "range_m", fov.range_m, 0);
  read_count(map, "columns", columns, 1, 4096);
  if (rows) read_count(map, "rows", *rows, 1, 4096);
  map.finish();
}

}  // namespace

Vehicle Vehicle::load(const std::string& path) {
  YamlMap map = YamlMap::load(path);
  Vehicle v;
  v.name = std::filesystem::path(path).stem().string();
  v.read(map);
  return v;
}

void Vehicle::read(YamlMap& map) {
  map.read("ground", ground);
  read_positive(map, "radius_m", radius_m);
  read_positive(map, "speed_mps", speed_mps);
  read_positive(map, "accel_mps2", accel_mps2);
  read_positive(map, "yaw_rate_radps", yaw_rate_radps);
  read_at_least(map, "ride_height_m", ride_height_m, 0);
  read_at_least(map, "max_step_m", max_step_m, 0);
  read_degrees(map, "max_slope_deg", max_slope_rad, 0, 90);
  read_field_of_view(map.child("camera"), camera, columns, &rows);
  read_degrees(map, "pitch_deg", pitch_rad, -90, 90);
  read_positive(map, "scan_rate_hz", scan_rate_hz);
  read_field_of_view(map.child("lidar"), lidar, lidar_columns, nullptr);
  read_positive(map, "capacity_mah", capacity_mah);
  read_at_least(map, "discharge_mah_per_s", discharge_mah_per_s, 0);
  map.finish();
  if (ground && ride_height_m < radius_m) {
    map.fail("ride_height_m", "must be at least radius_m, or the body touches the ground");
  }
}

}  // namespace muster::mission
