#include "commsim/world/scene.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "commsim/world/scene_file.h"
#include "commsim/world/triangle.h"

namespace muster::world {
namespace {

constexpr double kEndTolerance_m = 0.01;
constexpr double kGrazing =
    1e-3;  // sine of the angle to a surface below which its plane tells no distance

/// One device for the process: one thread and, on amd64, one instruction set, so that every machine
/// finds the same hits.
RTCDevice device() {
#if defined(__x86_64__)
  static const RTCDevice the_device = rtcNewDevice("threads=1,isa=sse4.2");
#else
  static const RTCDevice the_device = rtcNewDevice("threads=1");
#endif
  MUSTER_CHECK(the_device != nullptr);
  return the_device;
}

bool before(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

std::array<Vec3, 3> corners(const Mesh& mesh, std::size_t triangle) {
  const Eigen::Vector3i& t = mesh.triangles[triangle];
  const auto corner = [&](int i) -> Vec3 {
    return mesh.vertices[static_cast<std::size_t>(t[i])].cast<double>();
  };
  return {corner(0), corner(1), corner(2)};
}

/// Along a ray to the plane of the triangle that it meets. Embree's own answer is off by what a
/// processor makes of 1/x in single precision, each make in its way, and traces would differ.
std::optional<double> to_plane(const std::array<Vec3, 3>& triangle, const Vec3& origin,
                               const Vec3& unit_direction) {
  const auto& [a, b, c] = triangle;
  const Vec3 normal = (b - a).cross(c - a);
  const double steep = normal.dot(unit_direction);
  if (std::abs(steep) < kGrazing * normal.norm()) return std::nullopt;
  return normal.dot(a - origin) / steep;
}

struct NearestQuery {
  const Mesh* mesh;
  Vec3 point;
  double best_m;
};

bool shrink_to_nearest(RTCPointQueryFunctionArguments* args) {
  auto* q = static_cast<NearestQuery*>(args->userPtr);
  const auto [a, b, c] = corners(*q->mesh, args->primID);
  const double d = (closest_on_triangle(q->point, a, b, c) - q->point).norm();
  if (d >= q->best_m) return false;
  q->best_m = d;
  args->query->radius = static_cast<float>(d);
  return true;
}

}  // namespace

struct Scene::Impl {
  Mesh mesh;
  RTCScene scene = nullptr;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::max()), high = -low;

  ~Impl() {
    if (scene) rtcReleaseScene(scene);
  }

  void build() {
    // The last vertex is read with a 16-byte load: the buffers are Embree's own, which pads them.
    const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    for (const Eigen::Vector3f& v : mesh.vertices) {
      vertices = std::copy(v.data(), v.data() + 3, vertices);
      low = low.cwiseMin(v.cast<double>());
      high = high.cwiseMax(v.cast<double>());
    }
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), mesh.triangles.size()));
    for (const Eigen::Vector3i& t : mesh.triangles) {
      for (int i = 0; i < 3; ++i) *indices++ = static_cast<std::uint32_t>(t[i]);
    }
    rtcCommitGeometry(geometry);
    scene = rtcNewScene(device());
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
};

Scene::Scene(Mesh mesh) : impl_(std::make_unique<Impl>()) {
  check_mesh(mesh, "mesh");
  impl_->mesh = std::move(mesh);
  impl_->build();
}

Scene::~Scene() = default;

const Mesh& Scene::mesh() const { return impl_->mesh; }
Vec3 Scene::low() const { return impl_->low; }
Vec3 Scene::high() const { return impl_->high; }

std::optional<Hit> Scene::cast(const Vec3& origin, const Vec3& unit_direction, double max_m) const {
  RTCRayHit r{};
  r.ray.org_x = static_cast<float>(origin.x());
  r.ray.org_y = static_cast<float>(origin.y());
  r.ray.org_z = static_cast<float>(origin.z());
  r.ray.dir_x = static_cast<float>(unit_direction.x());
  r.ray.dir_y = static_cast<float>(unit_direction.y());
  r.ray.dir_z = static_cast<float>(unit_direction.z());
  r.ray.tfar = static_cast<float>(max_m);
  r.ray.mask = ~0u;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &r);
  if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  Hit hit;
  const auto exact_m = to_plane(corners(impl_->mesh, r.hit.primID), origin, unit_direction);
  hit.distance_m = std::clamp(exact_m.value_or(static_cast<double>(r.ray.tfar)), 0.0, max_m);
  hit.normal = Eigen::Vector3f(r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z).cast<double>().normalized();
  hit.from_behind = hit.normal.dot(unit_direction) > 0;
  if (hit.from_behind) hit.normal = -hit.normal;
  return hit;
}

bool Scene::line_of_sight(const Vec3& a, const Vec3& b) const {
  const Vec3& from = before(a, b) ? a : b;
  const Vec3 way = (before(a, b) ? b : a) - from;
  const double length_m = way.norm();
  if (length_m <= 2 * kEndTolerance_m) return true;
  const Eigen::Vector3f o = from.cast<float>(), d = (way / length_m).cast<float>();
  RTCRay ray{};
  ray.org_x = o.x(), ray.org_y = o.y(), ray.org_z = o.z();
  ray.dir_x = d.x(), ray.dir_y = d.y(), ray.dir_z = d.z();
  ray.tnear = static_cast<float>(kEndTolerance_m);
  ray.tfar = static_cast<float>(length_m - kEndTolerance_m);
  ray.mask = ~0u;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->scene, &context, &ray);
  return ray.tfar >= 0;
}

double Scene::clearance(const Vec3& p, double cap_m) const {
  RTCPointQuery query{};
  query.x = static_cast<float>(p.x());
  query.y = static_cast<float>(p.y());
  query.z = static_cast<float>(p.z());
  query.radius = static_cast<float>(cap_m);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  NearestQuery nearest{&impl_->mesh, p, cap_m};
  rtcPointQuery(impl_->scene, &query, &context, shrink_to_nearest, &nearest);
  return nearest.best_m;
}

std::shared_ptr<const Scene> Scene::load(const std::string& path) {
  return std::make_shared<const Scene>(load_mesh(path));
}

std::shared_ptr<const Scene> Scene::load(const mission::Mission& mission) {
  Mesh mesh = load_mesh(mission.scene_file);
  if (mission.ground) add_ground(mesh, mission.hull.low(), mission.hull.high());
  return std::make_shared<const Scene>(std::move(mesh));
}

}  // namespace muster::world
