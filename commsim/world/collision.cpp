#include "commsim/world/collision.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>

namespace muster::world {
namespace {

constexpr double kApartM = 0.05;   // a contact ends when this far apart
constexpr double kMarginM = 1e-3;  // Embree answers in single precision

}  // namespace

/// The scene's mesh as FCL knows it; built when first needed, since most flights never touch
/// anything.
struct CollisionChecker::Site {
  explicit Site(const Mesh& mesh) {
    model.beginModel(static_cast<int>(mesh.triangles.size()),
                     static_cast<int>(mesh.vertices.size()));
    std::vector<fcl::Vector3d> vertices;
    vertices.reserve(mesh.vertices.size());
    for (const Eigen::Vector3f& v : mesh.vertices) vertices.push_back(v.cast<double>());
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const Eigen::Vector3i& t : mesh.triangles) {
      triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                             static_cast<std::size_t>(t[2]));
    }
    model.addSubModel(vertices, triangles);
    model.endModel();
  }

  bool touches(const MovingBody& body) const {
    const fcl::Sphered sphere(body.radius_m);
    const fcl::Transform3d here(fcl::Translation3d(body.p));
    const fcl::CollisionRequestd request(64, true);
    fcl::CollisionResultd result;
    fcl::collide(&model, fcl::Transform3d::Identity(), &sphere, here, request, result);
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      if (!body.footing_z || result.getContact(i).pos.z() > *body.footing_z) return true;
    }
    return false;
  }

  fcl::BVHModel<fcl::OBBRSSd> model;
};

CollisionChecker::CollisionChecker(const Scene& scene) : scene_(scene) {}
CollisionChecker::~CollisionChecker() = default;

double CollisionChecker::clearance(std::size_t i, const MovingBody& body, double needed_m) {
  Known& known = known_[i];
  const double at_least = known.clearance_m - (body.p - known.p).norm();
  if (known.clearance_m >= 0 && at_least > needed_m) return at_least;
  known = {body.p, scene_.clearance(body.p, body.radius_m + kCareM)};
  return known.clearance_m;
}

bool CollisionChecker::touches_site(std::size_t i, const MovingBody& body) {
  if (body.resting) return false;
  const double gap_that_matters =
      body.flying ? std::max(kApartM, min_clearance_.value_or(kCareM - 0.5)) : kApartM;
  const double gap = clearance(i, body, body.radius_m + gap_that_matters) - body.radius_m;
  if (body.flying && gap < min_clearance_.value_or(kCareM)) min_clearance_ = gap;
  if (on_site_[i]) return gap <= kApartM;
  if (gap > kMarginM) return false;
  if (!site_) site_ = std::make_unique<Site>(scene_.mesh());
  return site_->touches(body);
}

std::vector<Contact> CollisionChecker::step(const std::vector<MovingBody>& bodies) {
  const std::size_t n = bodies.size();
  known_.resize(n);
  on_site_.resize(n);
  on_pair_.resize(n * n);
  std::vector<Contact> begun;
  for (std::size_t i = 0; i < n; ++i) {
    const bool touches = touches_site(i, bodies[i]);
    if (touches && !on_site_[i]) begun.push_back({bodies[i].id, kNoRobot, bodies[i].p});
    on_site_[i] = touches;
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      const double gap =
          (bodies[i].p - bodies[j].p).norm() - bodies[i].radius_m - bodies[j].radius_m;
      if (gap < min_separation_.value_or(gap + 1)) min_separation_ = gap;
      char& on = on_pair_[i * n + j];
      if (gap < 0 && !on) begun.push_back({bodies[i].id, bodies[j].id, bodies[i].p});
      on = on ? gap <= kApartM : gap < 0;
    }
  }
  return begun;
}

}  // namespace muster::world
