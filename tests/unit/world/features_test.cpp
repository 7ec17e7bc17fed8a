#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <numeric>

#include "commsim/world/observable.h"
#include "commsim/world/reachable.h"
#include "commsim/world/scene.h"
#include "commsim/world/surroundings.h"

using namespace muster;
using namespace muster::world;

namespace {

const std::string kPagoda = std::string(MUSTER_SOURCE_DIR) + "/deploy/missions/pagoda.yaml";

struct Site {
  explicit Site(const std::string& file)
      : mission(mission::Mission::load(file)), scene(Scene::load(mission)) {}
  mission::Mission mission;
  std::shared_ptr<const Scene> scene;
  ReachableSpace reachable{*scene, mission};
};

/// A hollow room (5 × 5 × 4 m outside, walls 0.3 m) on open ground, the explorer outside it.
Site closed_room() {
  Site site(kPagoda);
  Mesh mesh;
  const auto add_box = [&mesh](const Vec3& low, const Vec3& high, bool inwards) {
    const int n = static_cast<int>(mesh.vertices.size());
    for (int i = 0; i < 8; ++i) {
      mesh.vertices.emplace_back(static_cast<float>(i & 1 ? high.x() : low.x()),
                                 static_cast<float>(i & 2 ? high.y() : low.y()),
                                 static_cast<float>(i & 4 ? high.z() : low.z()));
    }
    static constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& f : kFaces) {
      mesh.triangles.emplace_back(n + f[0], n + f[inwards ? 2 : 1], n + f[inwards ? 1 : 2]);
      mesh.triangles.emplace_back(n + f[0], n + f[inwards ? 3 : 2], n + f[inwards ? 2 : 3]);
    }
  };
  add_box({-2.5, -2.5, 0}, {2.5, 2.5, 4}, false);
  add_box({-2.2, -2.2, 0.3}, {2.2, 2.2, 3.7}, true);
  add_box({-30, -30, -1}, {30, 30, 0}, false);
  site.scene = std::make_shared<const Scene>(std::move(mesh));
  site.reachable = ReachableSpace(*site.scene, site.mission);
  return site;
}

}  // namespace

TEST_CASE("reachable space keeps its margin and does not leak into closed rooms") {
  const Site site = closed_room();
  CHECK(site.reachable.contains({0, 8, 2}));
  CHECK(site.reachable.contains({0, 0, 6}));
  CHECK_FALSE(site.reachable.contains({0, 0, 2}));
  CHECK_FALSE(site.reachable.contains({0, 2.7, 2}));
  CHECK_FALSE(site.reachable.contains({0, 8, 0.2}));
  CHECK_FALSE(site.reachable.contains({0, 8, 16.9}));
  for (double x = -8; x < 8; x += 0.7) {
    for (double z = 0.1; z < 8; z += 0.3) {
      const Vec3 p(x, 3.05, z);
      // A cell's corner lies 0.22 m from its centre, where the margin holds.
      if (site.reachable.contains(p)) {
        CHECK(site.scene->clearance(p, 5) > site.reachable.margin_m() - 0.22);
      }
    }
  }
}

TEST_CASE("the surfaces of a closed room are neither features nor owed") {
  const Site site = closed_room();
  const auto inside = [](const Vec3& p) {
    return p.head<2>().cwiseAbs().maxCoeff() < 2.3 && p.z() < 3.8;
  };
  const FeatureSet set = draw_features(*site.scene, site.mission, site.reachable);
  for (const Feature& f : set.features) CHECK_FALSE(inside(f.position));
  CHECK(set.rejected > 0);
  const auto voxels = observable_surface(*site.scene, site.mission, site.reachable);
  std::size_t owed_inside = 0;
  for (const Voxel& v : voxels)
    owed_inside += inside({v.x * 0.2 + 0.1, v.y * 0.2 + 0.1, v.z * 0.2 + 0.1});
  CHECK(owed_inside == 0);
  // Four walls of 5 m from 0.3 m up; the flat roof only ever lies at a grazing angle, or below the
  // camera's view.
  CHECK(voxels.size() >= 4 * 24 * 17);
}

TEST_CASE("features are drawn as the rules say and the same way every time") {
  const Site site(kPagoda);
  const FeatureSet set = draw_features(*site.scene, site.mission, site.reachable);
  REQUIRE(set.features.size() == 150);
  CHECK(set.decoys.size() == 15);
  CHECK(set.drawn == set.features.size() + set.rejected);
  for (std::size_t i = 0; i < set.features.size(); ++i) {
    const Feature& f = set.features[i];
    CHECK(f.id == FeatureId{static_cast<std::uint32_t>(i)});
    CHECK(f.position.z() > 1);
    CHECK(site.mission.boxes[0].contains(f.position));
    CHECK(site.scene->clearance(f.position, 1) < 1e-3);
    CHECK(f.normal.norm() == Approx(1));
  }
  const FeatureSet again = draw_features(*site.scene, site.mission);
  for (std::size_t i = 0; i < set.features.size(); ++i) {
    CHECK(set.features[i].position == again.features[i].position);
  }
  mission::Mission other = site.mission;
  other.seed = 2;
  CHECK(draw_features(*site.scene, other).features[0].position != set.features[0].position);
}

TEST_CASE("every feature has a reachable view that satisfies the inspection rule") {
  // Of seed 2, one feature lay half a centimetre below another surface: in sight of a ray that ends
  // just before it, in no camera's sight.
  const std::uint64_t seed = GENERATE(1, 2);
  Site site(kPagoda);
  site.mission.seed = seed;
  const auto& inspector = site.mission.robot(RobotId{3}).vehicle;
  const Surroundings around(*site.scene, {});
  const auto seen = [&](const Feature& f, const Vec3& from, double range_m) {
    const Vec3 eye = f.position + range_m * from;
    const Pose pose{eye, std::atan2(-from.y(), -from.x())};
    return inspector.camera.contains(pose, inspector.pitch_rad, f.position) &&
           site.reachable.contains(eye) &&
           around.sees(eye, before_surface(f.position, f.normal), RobotId{3});
  };
  constexpr double kDegree = std::numbers::pi / 180;
  for (const Feature& f : draw_features(*site.scene, site.mission, site.reachable).features) {
    bool found = false;
    // An independent search, all around the feature.
    for (double el = -28; el <= 28 && !found; el += 2) {
      for (double az = 0; az < 360 && !found; az += 5) {
        const double level = std::cos(el * kDegree);
        const Vec3 from(level * std::cos(az * kDegree), level * std::sin(az * kDegree),
                        std::sin(el * kDegree));
        if (from.dot(f.normal) < 0.5) continue;
        for (const double range_m : {0.7, 1.0, 1.4, 1.9, 2.5, 3.2, 4.0, 4.8})
          found = found || seen(f, from, range_m);
      }
    }
    INFO("seed " << seed << " feature " << f.id.value);
    CHECK(found);
  }
}

TEST_CASE("a site that cannot hold its features is bad input") {
  Site site(kPagoda);
  site.mission.boxes = {Box::from_corners({-10, -11, 16}, {-9, -10, 16.5})};
  CHECK_THROWS_AS(draw_features(*site.scene, site.mission, site.reachable), BadInput);
}
