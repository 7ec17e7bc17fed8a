#include "commsim/world/observable.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "commsim/world/view.h"

namespace muster::world {
namespace {

constexpr double kSpacing_m = 0.14;
constexpr double kMaxIncidence_rad = 80 * std::numbers::pi / 180;
constexpr std::size_t kTriesPerVoxel = 3;

struct Sample {
  std::uint64_t key;  ///< of the voxel; orders as x, y, z do
  Eigen::Vector3f point;
  std::uint32_t triangle;
};

constexpr int kKeyOffset = 1 << 20;  // 21 bits for each axis

std::uint64_t key_of(const Eigen::Vector3i& v) {
  const auto part = [](int i) {
    const int from_zero = i + kKeyOffset;
    return static_cast<std::uint64_t>(from_zero);
  };
  return part(v.x()) << 42 | part(v.y()) << 21 | part(v.z());
}

Voxel voxel_of(std::uint64_t key) {
  const auto part = [key](int shift) {
    return static_cast<int>(key >> shift & 0x1FFFFF) - kKeyOffset;
  };
  return {part(42), part(21), part(0)};
}

Vec3 corner(const Mesh& mesh, std::size_t t, int i) {
  return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][i])].cast<double>();
}

/// Calls `use` for the centres of a grid of small triangles, `kSpacing_m` across.
template <class F>
void for_each_point(const Vec3& a, const Vec3& b, const Vec3& c, F use) {
  const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
  const int n = std::max(1, static_cast<int>(std::ceil(longest / kSpacing_m)));
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n - i; ++j) {
      use(a + (i + 1.0 / 3) / n * (b - a) + (j + 1.0 / 3) / n * (c - a));
    }
  }
}

std::vector<Box> boxes_near(const mission::Mission& mission, const Vec3& low, const Vec3& high) {
  std::vector<Box> near;
  for (const Box& box : mission.boxes) {
    if ((box.low().array() <= high.array()).all() && (box.high().array() >= low.array()).all()) {
      near.push_back(box);
    }
  }
  return near;
}

std::vector<Sample> surface_samples(const Mesh& mesh, const mission::Mission& mission) {
  std::vector<Sample> samples;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = corner(mesh, t, 0), b = corner(mesh, t, 1), c = corner(mesh, t, 2);
    const auto boxes = boxes_near(mission, a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c));
    if (boxes.empty()) continue;
    for_each_point(a, b, c, [&](const Vec3& p) {
      if (std::none_of(boxes.begin(), boxes.end(), [&](const Box& o) { return o.contains(p); }))
        return;
      const Eigen::Vector3i v = (p / mission.resolution_m).array().floor().cast<int>();
      samples.push_back({key_of(v), p.cast<float>(), static_cast<std::uint32_t>(t)});
    });
  }
  std::sort(samples.begin(), samples.end(), [](const Sample& x, const Sample& y) {
    return std::tuple(x.key, x.triangle, x.point.x(), x.point.y(), x.point.z()) <
           std::tuple(y.key, y.triangle, y.point.x(), y.point.y(), y.point.z());
  });
  return samples;
}

}  // namespace

std::vector<Voxel> observable_surface(const Scene& scene, const mission::Mission& mission,
                                      const ReachableSpace& reachable) {
  std::vector<ViewRule> rules;
  for (const RobotId id : mission.with_role(mission::Role::kExplorer)) {
    const auto& vehicle = mission.robot(id).vehicle;
    const ViewRule rule(vehicle, vehicle.camera.range_m, kMaxIncidence_rad);
    const bool known = std::find(rules.begin(), rules.end(), rule) != rules.end();
    if (!known && vehicle.camera.range_m > 0) rules.push_back(rule);
  }
  const Mesh& mesh = scene.mesh();
  const ViewFinder finder(scene, reachable, mission);
  std::vector<std::size_t> lucky(rules.size(), 0);
  const auto seen = [&](const Sample& s) {
    const Vec3 a = corner(mesh, s.triangle, 0), b = corner(mesh, s.triangle, 1),
               c = corner(mesh, s.triangle, 2);
    const Vec3 n = (b - a).cross(c - a).normalized(), p = s.point.cast<double>();
    for (const Vec3& normal : {Vec3(n), Vec3(-n)}) {
      if (!finder.is_outside(p, normal)) continue;
      for (std::size_t i = 0; i < rules.size(); ++i) {
        if (finder.can_see(p, normal, rules[i], lucky[i])) return true;
      }
    }
    return false;
  };
  const std::vector<Sample> samples = surface_samples(mesh, mission);
  std::vector<Voxel> voxels;
  for (std::size_t i = 0, end = 0; i < samples.size(); i = end) {
    end = i;
    while (end < samples.size() && samples[end].key == samples[i].key) ++end;
    // A few of the voxel's points, evenly: they may lie on different faces.
    const std::size_t tries = std::min(kTriesPerVoxel, end - i);
    for (std::size_t k = 0; k < tries; ++k) {
      if (!seen(samples[i + k * (end - i) / tries])) continue;
      voxels.push_back(voxel_of(samples[i].key));
      break;
    }
  }
  return voxels;
}

}  // namespace muster::world
