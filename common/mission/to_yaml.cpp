#include <charconv>
#include <cstdio>
#include <set>
#include <sstream>

#include "common/mission/mission.h"
#include "common/mission/radio_file.h"

namespace muster::mission {
namespace {

/// The shortest text that reads back as the same number.
std::string num(double x) {
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, x).ptr;
  return std::string(buffer, end);
}

/// 15 digits: what was written as degrees reads back as the same radians.
std::string degrees(double rad) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.15g", rad * 180 / std::numbers::pi);
  return buffer;
}

std::string vec(const Vec3& v) {
  std::ostringstream out;
  out << '[' << num(v.x()) << ", " << num(v.y()) << ", " << num(v.z()) << ']';
  return out.str();
}

std::string quoted(const std::string& s) {
  std::string out = "\"";
  for (char c : s) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string yes(bool b) { return b ? "true" : "false"; }

std::string box(const Box& b) {
  std::ostringstream out;
  out << "{center: " << vec(b.center) << ", size: " << vec(b.size)
      << ", yaw_deg: " << degrees(b.yaw_rad) << '}';
  return out.str();
}

void write_vehicle(std::ostream& out, const Vehicle& v) {
  out << "  " << quoted(v.name) << ":\n"
      << "    {ground: " << yes(v.ground) << ", radius_m: " << num(v.radius_m)
      << ", speed_mps: " << num(v.speed_mps) << ", accel_mps2: " << num(v.accel_mps2)
      << ", yaw_rate_radps: " << num(v.yaw_rate_radps)
      << ", ride_height_m: " << num(v.ride_height_m) << ", max_step_m: " << num(v.max_step_m)
      << ", max_slope_deg: " << degrees(v.max_slope_rad) << ",\n"
      << "     camera: {hfov_deg: " << degrees(v.camera.hfov_rad)
      << ", vfov_deg: " << degrees(v.camera.vfov_rad) << ", range_m: " << num(v.camera.range_m)
      << ", columns: " << v.columns << ", rows: " << v.rows
      << "}, pitch_deg: " << degrees(v.pitch_rad) << ", scan_rate_hz: " << num(v.scan_rate_hz)
      << ",\n     lidar: {hfov_deg: " << degrees(v.lidar.hfov_rad)
      << ", range_m: " << num(v.lidar.range_m) << ", columns: " << v.lidar_columns
      << "}, capacity_mah: " << num(v.capacity_mah)
      << ", discharge_mah_per_s: " << num(v.discharge_mah_per_s) << "}\n";
}

void write_fleet(std::ostream& out, const Mission& m) {
  out << "vehicles:\n";
  std::set<std::string> written;
  for (const RobotConfig& r : m.fleet) {
    if (written.insert(r.vehicle.name).second) write_vehicle(out, r.vehicle);
  }
  out << "fleet:\n";
  for (const RobotConfig& r : m.fleet) {
    out << "  - {role: " << role_name(r.role) << ", vehicle: " << quoted(r.vehicle.name)
        << ", first_id: " << r.id.value << ", skills: " << r.skills << ", starts: [["
        << num(r.start.p.x()) << ", " << num(r.start.p.y()) << ", " << num(r.start.p.z()) << ", "
        << degrees(r.start.yaw_rad) << "]]}\n";
  }
}

void write_settings(std::ostream& out, const Mission& m) {
  out << "standing: {place: " << vec(m.standing.place) << ", t0_s: " << num(m.standing.t0.s())
      << ", period_s: " << num(m.standing.period.s())
      << ", window_s: " << num(m.standing.window.s()) << "}\n";
  const SensingConfig& s = m.sensing;
  out << "sensing: {sighting_rate_hz: " << num(s.sighting_rate_hz)
      << ", sighting_range_m: " << num(s.sighting_range_m)
      << ", sighting_probability: " << num(s.sighting_probability)
      << ", sighting_sigma_m: " << num(s.sighting_sigma_m)
      << ", false_areas: " << num(s.false_areas) << ", range_noise_m: " << num(s.range_noise_m)
      << ", depth_noise: " << num(s.depth_noise) << "}\n";
  const InspectConfig& i = m.inspect;
  out << "inspect: {range_m: " << num(i.range_m)
      << ", max_incidence_deg: " << degrees(i.max_incidence_rad)
      << ", max_speed_mps: " << num(i.max_speed_mps) << ", hold_s: " << num(i.hold_s)
      << ", match_m: " << num(i.match_m) << ", shared: " << yes(i.shared)
      << ", payload_bytes: " << i.payload_bytes << "}\n";
  const FeatureConfig& f = m.features;
  out << "features: {count: " << f.count << ", min_height_m: " << num(f.min_height_m)
      << ", first_box_weight: " << num(f.first_box_weight)
      << ", priority_share: " << num(f.priority_share) << "}\n";
  out << radio_to_yaml(m.radio);
}

void write_lists(std::ostream& out, const Mission& m) {
  if (!m.charging.empty()) out << "charging:\n";
  for (const ChargingStation& c : m.charging) {
    out << "  - {place: " << vec(c.pose.p) << ", yaw_deg: " << degrees(c.pose.yaw_rad)
        << ", slots: " << c.slots << ", rate_per_s: " << num(c.rate_per_s)
        << ", reach_m: " << num(c.reach_m) << "}\n";
  }
  write_script(out, m.script);
}

}  // namespace

std::string Mission::to_yaml() const {
  std::ostringstream out;
  out << "name: " << quoted(name) << "\nscene: " << quoted(scene_file)
      << "\nground: " << yes(ground) << "\nhull: " << box(hull) << "\nboxes:\n";
  for (const Box& b : boxes) out << "  - " << box(b) << "\n";
  out << "strategy: " << strategy << "\nseed: " << seed << "\ntime_limit_s: " << num(time_limit_s)
      << "\ncoverage: " << (coverage_counts_surface ? "surface" : "volume")
      << "\nmeeting_tolerance_s: " << num(meeting_tolerance_s)
      << "\nbattery_reserve: " << num(battery_reserve)
      << "\nlost_contact_s: " << num(lost_contact_s) << "\nresolution_m: " << num(resolution_m)
      << "\nfree_ball_m: " << num(free_ball_m) << "\nclearance_m: " << num(clearance_m) << "\n";
  write_fleet(out, *this);
  write_settings(out, *this);
  write_lists(out, *this);
  return out.str();
}

}  // namespace muster::mission
