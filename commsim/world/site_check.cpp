#include "commsim/world/site_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "common/core/error.h"

namespace muster::world {
namespace {

constexpr double kTouchM = 0.005;

[[noreturn]] void refuse(const std::string& place, const std::string& what) {
  throw BadInput(place + ": " + what);
}

/// Where the mission's file says where `r` starts. A mission made by code has no lines.
std::string place_of(const mission::Mission& mission, const mission::RobotConfig& r) {
  return r.place.empty() ? mission.file + ": fleet" : r.place;
}

std::string place_of_box(const mission::Mission& mission, std::size_t i) {
  return i < mission.box_places.size() ? mission.box_places[i]
                                       : mission.file + ": boxes[" + std::to_string(i) + "]";
}

std::string metres(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f m", v);
  return text;
}

std::string robot_at(const mission::RobotConfig& r) {
  char text[96];
  std::snprintf(text, sizeof text, "robot %u at (%.2f, %.2f, %.2f)", r.id.value, r.start.p.x(),
                r.start.p.y(), r.start.p.z());
  return text;
}

/// +1: the ray leaves through the triangle's back, −1: it enters through its front, 0: it misses
/// (Möller–Trumbore).
int crossing(const Vec3& p, const Vec3& d, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, h = d.cross(ac);
  const double det = ab.dot(h);
  if (std::abs(det) < 1e-12) return 0;
  const Vec3 s = p - a;
  const double u = s.dot(h) / det;
  if (u < 0 || u > 1) return 0;
  const Vec3 q = s.cross(ab);
  const double v = d.dot(q) / det;
  if (v < 0 || u + v > 1 || ac.dot(q) / det <= 0) return 0;
  return d.dot(ab.cross(ac)) > 0 ? 1 : -1;
}

std::vector<Vec3> upward_directions() {
  std::vector<Vec3> directions;
  // Slightly odd angles, so that no ray runs along an edge of an axis-aligned wall.
  for (int i = 0; i < 8; ++i) {
    const double az = 0.137 + i * std::numbers::pi / 4;
    for (const double el : {0.071, 0.713}) directions.push_back(ray_direction(0, 0, az, el));
  }
  directions.push_back(Vec3(0.0131, 0.0077, 1).normalized());
  return directions;
}

void check_boxes(const mission::Mission& mission, const Scene& scene) {
  const Vec3 low = scene.low(), high = scene.high();
  for (std::size_t i = 0; i < mission.boxes.size(); ++i) {
    const Vec3 box_low = mission.boxes[i].low(), box_high = mission.boxes[i].high();
    if ((box_high.array() < low.array()).any() || (box_low.array() > high.array()).any()) {
      char text[160];
      std::snprintf(text, sizeof text,
                    "lies outside the scene, which is x %.1f..%.1f, y %.1f..%.1f, z %.1f..%.1f",
                    low.x(), high.x(), low.y(), high.y(), low.z(), high.z());
      refuse(place_of_box(mission, i), text);
    }
  }
}

void check_start(const mission::Mission& mission, const Scene& scene,
                 const mission::RobotConfig& robot) {
  const mission::Vehicle& v = robot.vehicle;
  Vec3 p = robot.start.p;
  const std::string place = place_of(mission, robot);
  if (inside_solid(scene.mesh(), p)) {
    refuse(place, robot_at(robot) + " starts inside a wall; a free place is expected");
  }
  if (v.ground) {
    const auto ground = scene.cast(p, -Vec3::UnitZ(), v.ride_height_m + 2);
    if (!ground) refuse(place, robot_at(robot) + " has no ground below to stand on");
    p.z() += v.ride_height_m - ground->distance_m;
  }
  const double needed = (v.ground ? std::min(v.radius_m, v.ride_height_m - kTouchM) : v.radius_m);
  const double gap = scene.clearance(p, needed + 1);
  if (gap < needed + kTouchM) {
    refuse(place, robot_at(robot) + " starts " + metres(gap) +
                      " from a surface; its body has a radius of " + metres(v.radius_m));
  }
}

void check_overlaps(const mission::Mission& mission) {
  for (std::size_t i = 0; i < mission.fleet.size(); ++i) {
    for (std::size_t j = i + 1; j < mission.fleet.size(); ++j) {
      const auto &a = mission.fleet[i], &b = mission.fleet[j];
      const double apart = (a.start.p - b.start.p).norm();
      const double needed = a.vehicle.radius_m + b.vehicle.radius_m;
      if (apart <= needed) {
        refuse(place_of(mission, a), robot_at(a) + " overlaps robot " + std::to_string(b.id.value) +
                                         ": " + metres(apart) + " apart, their bodies need " +
                                         metres(needed));
      }
    }
  }
}

}  // namespace

bool inside_solid(const Mesh& mesh, const Vec3& p) {
  static const std::vector<Vec3> directions = upward_directions();
  const auto vertex = [&](int i) {
    return mesh.vertices[static_cast<std::size_t>(i)].cast<double>().eval();
  };
  for (const Vec3& d : directions) {
    int net = 0;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      net += crossing(p, d, vertex(t[0]), vertex(t[1]), vertex(t[2]));
    }
    if (net < 1) return false;
  }
  return true;
}

void check_site(const mission::Mission& mission, const Scene& scene) {
  check_boxes(mission, scene);
  for (const mission::RobotConfig& r : mission.fleet) check_start(mission, scene, r);
  check_overlaps(mission);
}

}  // namespace muster::world
