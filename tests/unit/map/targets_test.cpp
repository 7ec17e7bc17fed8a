#include "common/map/targets.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <iostream>

#include "tests/unit/map/explorer.h"

using namespace muster;
using namespace muster::map;

namespace {

/// A house with a door and a window on a plain, an overhanging roof, and two columns; the box is 12
/// × 12 × 8 m.
const toy::World kSite{{{{-15, -15, -1}, {15, 15, 0}},
                        {{-2.03, -2.03, 0}, {2.03, -1.83, 4}},
                        {{-2.03, 1.83, 0}, {2.03, 2.03, 4}},
                        {{-2.03, -1.83, 0}, {-1.83, 1.83, 4}},
                        {{1.83, -1.83, 0}, {2.03, -0.7, 4}},  // the door is 1.4 m wide, 2.5 m high
                        {{1.83, 0.7, 0}, {2.03, 1.83, 4}},
                        {{1.83, -0.7, 2.5}, {2.03, 0.7, 4}},
                        {{-2.6, -2.6, 4}, {2.6, 2.6, 4.2}},
                        {{4.1, 3.1, 0}, {4.5, 3.5, 3}},
                        {{-4.5, 3.1, 0}, {-4.1, 3.5, 5}}}};
const Box kBox = Box::from_corners({-6, -6, 0}, {6, 6, 8});

MapConfig site_config() {
  MapConfig c;
  c.bounds = Box::from_corners({-9, -9, 0}, {9, 9, 10});
  return c;
}

TargetConfig target_config(std::uint32_t looks) {
  TargetConfig c;
  c.camera = {std::numbers::pi / 2, std::numbers::pi / 3, 5};
  c.looks = looks;
  return c;
}

/// Share of the truly observable surface (seen from somewhere on a 0.8 m grid of clear places) that
/// the map holds within a voxel.
double surface_known(const VoxelMap& m) {
  std::vector<Vec3> places;
  for (double x = -6.5; x <= 6.5; x += 0.8) {
    for (double y = -6.5; y <= 6.5; y += 0.8) {
      for (double z = 0.6; z <= 8; z += 0.8) {
        const Vec3 p(x, y, z);
        bool clear = true;
        for (int i = 0; i < 27; ++i) {
          clear &= !kSite.inside(p + 0.4 * Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
        }
        if (clear) places.push_back(p);
      }
    }
  }
  std::size_t observable = 0, known = 0;
  for (const auto& s : kSite.solids) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool top : {false, true}) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (double a = s.low[u] + 0.1; a < s.high[u]; a += 0.2) {
          for (double b = s.low[v] + 0.1; b < s.high[v]; b += 0.2) {
            Vec3 p;
            p[axis] = top ? s.high[axis] : s.low[axis];
            p[u] = a;
            p[v] = b;
            Vec3 normal = Vec3::Zero();
            normal[axis] = top ? 1 : -1;
            const Vec3 before = p + 0.02 * normal;
            if (!kBox.contains(p) || kSite.inside(before)) continue;
            const bool seen = std::ranges::any_of(places, [&](const Vec3& q) {
              const Vec3 d = before - q;
              return d.norm() < 4.5 && d.normalized().dot(normal) < -0.2 &&
                     kSite.cast(q, d.normalized()) > d.norm();
            });
            if (!seen) continue;
            ++observable;
            const VoxelKey k = m.key(p);
            bool held = false;
            for (int i = 0; i < 27 && !held; ++i) {
              held = m.at(VoxelKey{k.x + i % 3 - 1, k.y + i / 3 % 3 - 1, k.z + i / 9 - 1}) ==
                     Voxel::kOccupied;
            }
            known += held;
          }
        }
      }
    }
  }
  return static_cast<double>(known) / static_cast<double>(observable);
}

}  // namespace

TEST_CASE("a greedy explorer gets a box with a house done") {
  const bool noisy = GENERATE(false, true);
  const std::uint32_t looks = GENERATE(0u, 2u);
  VoxelMap m(site_config());
  const std::size_t watched = m.watch(kBox);
  Targets targets(m, kBox, target_config(looks));
  Random random(3, RobotId{1}, "explorer");
  const toy::Sensor sensor = noisy ? toy::Sensor::noisy() : toy::Sensor{};
  const auto e =
      toy::explore(kSite, m, targets, {{7, -7, 1.5}, 2.3}, sensor, noisy ? &random : nullptr, 500);
  const double known = surface_known(m);
  std::cout << (noisy ? "noisy" : "exact") << ", looks " << looks << ": " << e.views << " views, "
            << e.length_m << " m, surface " << known << ", volume "
            << m.known_m3(watched) / m.volume_m3(watched) << ", refused "
            << targets.refused().size() << ", left " << targets.frontier_m2() << " m² + "
            << targets.owed_surface_m2() << " m², update " << e.update_ms / e.updates
            << " ms mean of " << e.updates << ", worst " << e.worst_update_ms << "\n";
  CHECK(e.done);
  CHECK(known >= 0.95);
}

TEST_CASE("a box of which nothing is known is not done, and one that no pose sees is refused") {
  VoxelMap m(site_config());
  Targets targets(m, kBox, target_config(0));
  targets.update([](const Vec3&) { return true; });
  CHECK_FALSE(targets.done());
  toy::see(m, kSite, {{5, -5, 1.5}, 2.3});
  targets.update([](const Vec3&) { return true; });
  CHECK_FALSE(targets.viewpoints().empty());
  CHECK_FALSE(targets.done());
  CHECK(targets.frontier_m2() > 5);
  VoxelMap same(site_config());
  Targets unreachable(same, kBox, target_config(0));
  toy::see(same, kSite, {{5, -5, 1.5}, 2.3});
  for (int i = 0; i < 3; ++i) unreachable.update([](const Vec3&) { return false; });
  CHECK(unreachable.viewpoints().empty());
  CHECK(unreachable.done());
  CHECK(unreachable.frontier_m2() == 0);
  REQUIRE_FALSE(unreachable.refused().empty());
  CHECK(unreachable.refused().front().reason.starts_with("frontier: "));
}

TEST_CASE("a viewpoint sees its cluster from where the body may be") {
  VoxelMap m(site_config());
  m.insert_free_ball({5, -5, 1.5}, 1.5);
  for (int i = 0; i < 4; ++i) toy::see(m, kSite, {{5, -5, 1.5}, 1.5 * i});
  Targets targets(m, kBox, target_config(2));
  for (int i = 0; i < 10; ++i) targets.update([](const Vec3& p) { return p.x() > 3; });
  REQUIRE(targets.viewpoints().size() > 3);
  std::uint32_t last = 0;
  bool frontier = false;
  for (const Viewpoint& v : targets.viewpoints()) {
    CHECK(m.traversable(v.pose.p));
    CHECK(v.pose.p.x() > 3);
    CHECK(v.gain > 0);
    if (!v.surface) {
      frontier = true;
      CHECK(v.cluster >= last);
      last = v.cluster;
    }
  }
  CHECK(frontier);
}

TEST_CASE(
    "surfaces are looked at when they promise what is asked for, and refused with that reason") {
  VoxelMap m(site_config());
  m.insert_free_ball({5, -5, 1.5}, 1.5);
  for (int i = 0; i < 4; ++i) toy::see(m, kSite, {{5, -5, 1.5}, 1.5 * i});
  Targets targets(m, kBox, target_config(2));
  const auto surfaces = [&](double promise_m2) {
    targets.ask_for(promise_m2, true);
    for (int i = 0; i < 10; ++i) targets.update([](const Vec3&) { return true; });
    return std::ranges::count_if(targets.viewpoints(), &Viewpoint::surface);
  };
  const auto many = surfaces(0.1), few = surfaces(1.5);
  CHECK(few > 0);
  CHECK(few < many);
  CHECK(surfaces(100) == 0);
  CHECK(std::ranges::any_of(targets.refused(), [](const Refused& r) {
    return r.reason == "surface: looks promise less than 100.00 m²";
  }));
}

TEST_CASE("the same flight gives the same viewpoints") {
  const auto fly = [] {
    VoxelMap m(site_config());
    Targets targets(m, kBox, target_config(1));
    Random random(9, RobotId{2}, "explorer");
    return toy::explore(kSite, m, targets, {{7, -7, 1.5}, 2.3}, toy::Sensor::noisy(), &random, 12)
        .path;
  };
  const auto a = fly(), b = fly();
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].pose.p == b[i].pose.p);
    CHECK(a[i].pose.yaw_rad == b[i].pose.yaw_rad);
    CHECK(a[i].gain == b[i].gain);
  }
}
