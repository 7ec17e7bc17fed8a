#include <algorithm>
#include <filesystem>
#include <map>

#include "common/mission/data.h"
#include "common/mission/mission.h"
#include "common/mission/overrides.h"
#include "common/mission/radio_file.h"
#include "common/mission/reading.h"

namespace fs = std::filesystem;

namespace muster::mission {
namespace {

std::string text(RobotId id) { return std::to_string(id.value); }

/// `{low, high}` or `{center, size, yaw_deg}`.
Box read_box(YamlMap map) {
  Box box;
  if (map.has("low") || map.has("high")) {
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
    map.require("low", low);
    map.require("high", high);
    if ((high.array() <= low.array()).any()) map.fail("high", "must be above `low` in x, y and z");
    box = Box::from_corners(low, high);
  } else {
    map.require("center", box.center);
    map.require("size", box.size);
    if ((box.size.array() <= 0).any()) map.fail("size", "must be greater than 0 in x, y and z");
    read_degrees(map, "yaw_deg", box.yaw_rad, -360, 360);
  }
  map.finish();
  return box;
}

bool inside(const Box& inner, const Box& outer) {
  const auto corners = inner.corners();
  return std::all_of(corners.begin(), corners.end(),
                     [&](const Vec3& c) { return outer.contains(c, 1e-6); });
}

Role read_role(YamlMap& map) {
  std::string role;
  map.require("role", role);
  if (role == "station") return Role::kStation;
  if (role == "explorer") return Role::kExplorer;
  if (role == "inspector") return Role::kInspector;
  map.fail("role", "'" + role + "' is not one of station, explorer, inspector");
}

/// `[x, y, z]` or `[x, y, z, yaw_deg]`.
Pose read_start(const YamlMap& group, const std::vector<double>& numbers) {
  if (numbers.size() != 3 && numbers.size() != 4) {
    group.fail("starts", "each is [x, y, z] or [x, y, z, yaw_deg]");
  }
  for (double x : numbers) {
    if (!std::isfinite(x)) group.fail("starts", "must be finite");
  }
  Pose pose{{numbers[0], numbers[1], numbers[2]}, 0};
  if (numbers.size() == 4) pose.yaw_rad = wrap_angle(numbers[3] * std::numbers::pi / 180);
  return pose;
}

/// The vehicles of a mission: a file each, with what the mission's `vehicles` says on top.
class Vehicles {
 public:
  Vehicles(YamlMap inline_ones, std::string folder)
      : inline_(std::move(inline_ones)), folder_(std::move(folder)) {}

  void assign(const YamlMap& group, const std::string& name, RobotConfig& robot) {
    const auto known = known_.find(name);
    if (known == known_.end()) known_[name] = read(group, name);
    robot.vehicle = known_[name].first;
    robot.vehicle_file = known_[name].second;
  }
  void finish() const { inline_.finish(); }

 private:
  std::pair<Vehicle, std::string> read(const YamlMap& group, const std::string& name) {
    const auto file = find_data(name, folder_, "vehicles");
    if (!file && !inline_.has(name)) {
      group.fail("vehicle", "there is no vehicle file '" + name + "'");
    }
    Vehicle v;
    if (file) v = Vehicle::load(*file);
    v.name = fs::path(name).stem().string();
    YamlMap changes = inline_.child(name);
    v.read(changes);
    return {v, file.value_or("")};
  }

  YamlMap inline_;
  std::string folder_;
  std::map<std::string, std::pair<Vehicle, std::string>> known_;
};

void read_group(YamlMap& group, Vehicles& vehicles, Mission& m) {
  const Role role = read_role(group);
  std::string vehicle;
  group.require("vehicle", vehicle);
  std::vector<std::vector<double>> starts;
  group.require("starts", starts);
  if (starts.empty()) group.fail("starts", "is empty: one place for each robot is expected");
  std::uint32_t first_id = 0, skills = 0;
  group.require("first_id", first_id);
  group.read("skills", skills);
  group.finish();
  for (const auto& numbers : starts) {
    RobotConfig robot;
    robot.id = RobotId{first_id++};
    robot.role = role;
    robot.skills = skills;
    robot.start = read_start(group, numbers);
    robot.place = group.place("starts");
    vehicles.assign(group, vehicle, robot);
    if (robot.id.value == 0 || robot.id >= kRadioId) {
      group.fail("first_id", "robot ids are 1 and above");
    }
    if (m.has(robot.id)) group.fail("first_id", "robot " + text(robot.id) + " is there twice");
    if (!m.hull.contains(robot.start.p, -robot.vehicle.radius_m)) {
      group.fail("starts", "robot " + text(robot.id) + " starts outside the hull");
    }
    if (role == Role::kStation && !robot.vehicle.ground) {
      group.fail("vehicle", "a station needs a ground vehicle");
    }
    for (const RobotConfig& other : m.fleet) {
      if ((other.start.p - robot.start.p).norm() <
          other.vehicle.radius_m + robot.vehicle.radius_m) {
        group.fail("starts", "robots " + text(other.id) + " and " + text(robot.id) + " touch");
      }
    }
    m.fleet.push_back(std::move(robot));
  }
}

void read_fleet(YamlMap& map, const std::string& folder, Mission& m) {
  Vehicles vehicles(map.child("vehicles"), folder);
  if (!map.has("fleet")) map.fail("", "'fleet' is missing");
  for (YamlMap& group : map.list("fleet")) read_group(group, vehicles, m);
  vehicles.finish();
  std::sort(m.fleet.begin(), m.fleet.end(),
            [](const RobotConfig& a, const RobotConfig& b) { return a.id < b.id; });
  if (m.with_role(Role::kStation).empty()) map.fail("fleet", "a fleet needs a station");
  if (m.with_role(Role::kExplorer).empty()) map.fail("fleet", "a fleet needs an explorer");
  if (m.features.count > 0 && m.with_role(Role::kInspector).empty()) {
    map.fail("fleet", "a fleet needs an inspector, or `features.count: 0`");
  }
}

void read_standing(YamlMap map, Mission& m) {
  StandingConfig& c = m.standing;
  map.require("place", c.place);
  if (!m.hull.contains(c.place)) map.fail("place", "is outside the hull");
  double t0_s = c.t0.s(), period_s = c.period.s(), window_s = c.window.s();
  read_at_least(map, "t0_s", t0_s, 0);
  read_positive(map, "period_s", period_s);
  read_positive(map, "window_s", window_s);
  if (window_s > period_s) map.fail("window_s", "must not be longer than period_s");
  map.finish();
  c.t0 = Duration::from_s(t0_s);
  c.period = Duration::from_s(period_s);
  c.window = Duration::from_s(window_s);
}

void read_sensing(YamlMap map, SensingConfig& c) {
  read_positive(map, "sighting_rate_hz", c.sighting_rate_hz);
  read_positive(map, "sighting_range_m", c.sighting_range_m);
  read_between(map, "sighting_probability", c.sighting_probability, 0, 1);
  read_at_least(map, "sighting_sigma_m", c.sighting_sigma_m, 0);
  read_between(map, "false_areas", c.false_areas, 0, 10);
  read_at_least(map, "range_noise_m", c.range_noise_m, 0);
  read_between(map, "depth_noise", c.depth_noise, 0, 1);
  map.finish();
}

void read_inspect(YamlMap map, InspectConfig& c) {
  read_positive(map, "range_m", c.range_m);
  read_degrees(map, "max_incidence_deg", c.max_incidence_rad, 1, 89);
  read_positive(map, "max_speed_mps", c.max_speed_mps);
  read_positive(map, "hold_s", c.hold_s);
  read_positive(map, "match_m", c.match_m);
  map.read("shared", c.shared);
  read_count(map, "payload_bytes", c.payload_bytes, 0, 100'000'000);
  map.finish();
}

void read_features(YamlMap map, FeatureConfig& c) {
  read_count(map, "count", c.count, 0, 100'000);
  read_at_least(map, "min_height_m", c.min_height_m, 0);
  read_positive(map, "first_box_weight", c.first_box_weight);
  read_between(map, "priority_share", c.priority_share, 0, 1);
  map.finish();
}

ChargingStation read_charging(YamlMap map, const Mission& m) {
  ChargingStation c;
  map.require("place", c.pose.p);
  if (!m.hull.contains(c.pose.p)) map.fail("place", "is outside the hull");
  read_degrees(map, "yaw_deg", c.pose.yaw_rad, -360, 360);
  read_count(map, "slots", c.slots, 1, 1000);
  read_positive(map, "rate_per_s", c.rate_per_s);
  read_positive(map, "reach_m", c.reach_m);
  map.finish();
  return c;
}

void read_boxes(YamlMap& map, Mission& m) {
  for (YamlMap& item : map.list("boxes")) {
    m.boxes.push_back(read_box(item));
    m.box_places.push_back(item.place(""));
    if (!inside(m.boxes.back(), m.hull)) item.fail("", "the box reaches outside the hull");
  }
  if (m.boxes.empty()) map.fail("boxes", "at least one bounding box is expected");
}

void read_limits(YamlMap& map, Mission& m) {
  map.read("seed", m.seed);
  read_positive(map, "time_limit_s", m.time_limit_s);
  map.read("strategy", m.strategy);
  const auto& known = strategies();
  if (std::find(known.begin(), known.end(), m.strategy) == known.end()) {
    std::string names;
    for (const auto& s : known) names += (names.empty() ? "" : ", ") + s;
    map.fail("strategy", "'" + m.strategy + "' is not one of " + names);
  }
  std::string coverage = m.coverage_counts_surface ? "surface" : "volume";
  map.read("coverage", coverage);
  if (coverage != "surface" && coverage != "volume") {
    map.fail("coverage", "'" + coverage + "' is not one of surface, volume");
  }
  m.coverage_counts_surface = coverage == "surface";
  read_at_least(map, "meeting_tolerance_s", m.meeting_tolerance_s, 0);
  read_between(map, "battery_reserve", m.battery_reserve, 0, 1);
  read_positive(map, "lost_contact_s", m.lost_contact_s);
  read_between(map, "resolution_m", m.resolution_m, 0.05, 1);
  read_positive(map, "free_ball_m", m.free_ball_m);
  read_at_least(map, "clearance_m", m.clearance_m, 0);
}

void read_scene(YamlMap& map, const std::string& folder, Mission& m) {
  std::string scene;
  map.require("scene", scene);
  const auto file = find_data(scene, folder, "scenes");
  if (!file) map.fail("scene", "there is no file '" + scene + "'");
  m.scene_file = *file;
  map.read("ground", m.ground);
}

Mission read_mission(YamlMap map, const std::string& path) {
  const std::string folder = fs::absolute(path).parent_path().string();
  Mission m;
  m.file = path;
  m.name = fs::path(path).stem().string();
  map.read("name", m.name);
  read_scene(map, folder, m);
  if (!map.has("hull")) map.fail("", "'hull' is missing");
  m.hull = read_box(map.child("hull"));
  read_boxes(map, m);
  read_limits(map, m);
  read_sensing(map.child("sensing"), m.sensing);
  read_inspect(map.child("inspect"), m.inspect);
  read_features(map.child("features"), m.features);
  read_fleet(map, folder, m);
  if (!map.has("standing")) map.fail("", "'standing' is missing");
  read_standing(map.child("standing"), m);
  read_radio(map.child("radio"), m);
  for (YamlMap& item : map.list("charging")) m.charging.push_back(read_charging(item, m));
  m.script = read_script(map, m);
  map.finish();
  return m;
}

}  // namespace

Mission Mission::load(const std::string& path) {
  YamlMap map = YamlMap::load(path);
  return read_mission(std::move(map), path);
}

Mission Mission::load(const std::string& path, const std::vector<std::string>& overrides) {
  Mission plain = load(path);  // so that the file's own mistakes are told with their line
  if (overrides.empty()) return plain;
  YAML::Node root = YAML::LoadFile(path);
  for (const std::string& assignment : overrides) {
    apply_override(root, assignment);
    try {
      read_mission(YamlMap(YAML::Clone(root), path, ""), path);
    } catch (const BadInput& e) {
      throw BadInput("--set " + assignment + ": " + without_place(e.what(), path));
    }
  }
  return read_mission(YamlMap(root, path, ""), path);
}

Mission Mission::load(const std::string& path, const std::vector<std::string>& overrides,
                      const std::string& faults_file) {
  Mission mission = load(path, overrides);
  if (!faults_file.empty()) add_faults(mission, faults_file);
  return mission;
}

Mission Mission::without_script() const {
  Mission mission = *this;
  mission.script.clear();
  return mission;
}

}  // namespace muster::mission
