#pragma once

#include <initializer_list>
#include <memory>

#include "common/dds/convert.h"
#include "commsim/world/world.h"

/// A small hand-made site for the world's tests: a ground plate at z = 0 from −20 to 20, and walls
/// where a test wants them.
namespace muster::world::testing {

inline void add_plate(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const int first = static_cast<int>(mesh.vertices.size());
  for (const Vec3& p : {a, b, c, d}) mesh.vertices.push_back(p.cast<float>());
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  mesh.triangles.emplace_back(first, first + 2, first + 3);
}

inline Mesh ground() {
  Mesh mesh;
  add_plate(mesh, {-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0});
  return mesh;
}

/// A sheet in the plane x = `x`, its front towards −x.
inline void add_wall(Mesh& mesh, double x, double y_low, double y_high, double z_high) {
  add_plate(mesh, {x, y_high, 0}, {x, y_high, z_high}, {x, y_low, z_high}, {x, y_low, 0});
}

/// A closed solid, outward normals.
inline void add_solid(Mesh& mesh, const Vec3& l, const Vec3& h) {
  add_plate(mesh, {l.x(), l.y(), h.z()}, {h.x(), l.y(), h.z()}, {h.x(), h.y(), h.z()},
            {l.x(), h.y(), h.z()});
  add_plate(mesh, {l.x(), l.y(), l.z()}, {l.x(), h.y(), l.z()}, {h.x(), h.y(), l.z()},
            {h.x(), l.y(), l.z()});
  add_plate(mesh, {l.x(), l.y(), l.z()}, {h.x(), l.y(), l.z()}, {h.x(), l.y(), h.z()},
            {l.x(), l.y(), h.z()});
  add_plate(mesh, {h.x(), h.y(), l.z()}, {l.x(), h.y(), l.z()}, {l.x(), h.y(), h.z()},
            {h.x(), h.y(), h.z()});
  add_plate(mesh, {h.x(), l.y(), l.z()}, {h.x(), h.y(), l.z()}, {h.x(), h.y(), h.z()},
            {h.x(), l.y(), h.z()});
  add_plate(mesh, {l.x(), h.y(), l.z()}, {l.x(), l.y(), l.z()}, {l.x(), l.y(), h.z()},
            {l.x(), h.y(), h.z()});
}

inline mission::RobotConfig robot(std::uint32_t id, mission::Role role, const Vec3& p,
                                  double yaw_rad = 0) {
  mission::RobotConfig r;
  r.id = RobotId{id};
  r.role = role;
  r.start = {p, yaw_rad};
  return r;
}

inline mission::RobotConfig rover(std::uint32_t id, const Vec3& p) {
  mission::RobotConfig r = robot(id, mission::Role::kStation, p);
  r.vehicle.ground = true;
  r.vehicle.camera.range_m = 0;
  r.vehicle.lidar.range_m = 8;
  return r;
}

inline mission::Mission mission_of(std::vector<mission::RobotConfig> fleet) {
  mission::Mission m;
  m.name = "test";
  m.file = "test.yaml";
  m.hull = Box::from_corners({-20, -20, 0}, {20, 20, 10});
  m.boxes = {Box::from_corners({-10, -10, 0}, {10, 10, 8})};
  m.fleet = std::move(fleet);
  m.inspect.payload_bytes = 1000;
  return m;
}

inline Feature feature(std::uint32_t id, const Vec3& p, const Vec3& normal, bool real = true) {
  Feature f;
  f.id = FeatureId{id};
  f.position = p;
  f.normal = normal;
  f.real = real;
  return f;
}

inline mission::TimedState state(double t_s, const Vec3& p, const Vec3& v = Vec3::Zero(),
                                 double yaw_rad = 0) {
  return {SimTime::from_s(t_s), p, v, yaw_rad};
}

/// A message of robot `src`, as it would come from its process.
template <class T>
mission::Message from(std::uint32_t src, T message) {
  message.envelope.src = RobotId{src};
  message.envelope.n = 1;
  return dds::encode(message);
}

template <class T>
std::vector<T> all_of(const std::vector<World::Samples>& samples, std::uint32_t robot,
                      mission::MessageClass cls) {
  std::vector<T> found;
  for (const World::Samples& s : samples) {
    if (s.robot != RobotId{robot}) continue;
    for (const mission::Message& m : s.messages) {
      if (m.cls == cls) found.push_back(dds::decode<T>(m));
    }
  }
  return found;
}

/// Runs ticks [from, until) without commands and collects what `robot` was told by messages of
/// class T.
template <class T>
std::vector<T> run(World& world, std::uint64_t from, std::uint64_t until, std::uint32_t robot,
                   mission::MessageClass cls) {
  std::vector<T> result;
  for (std::uint64_t k = from; k < until; ++k) {
    for (T& m : all_of<T>(world.begin_tick(k), robot, cls)) result.push_back(std::move(m));
    world.end_tick(k, {});
  }
  return result;
}

inline void run(World& world, std::uint64_t from, std::uint64_t until) {
  for (std::uint64_t k = from; k < until; ++k) {
    world.begin_tick(k);
    world.end_tick(k, {});
  }
}

inline std::shared_ptr<const Scene> scene_of(Mesh mesh) {
  return std::make_shared<const Scene>(std::move(mesh));
}

}  // namespace muster::world::testing
