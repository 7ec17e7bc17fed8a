#include <catch2/catch.hpp>

#include "commsim/world/reachable.h"
#include "commsim/world/scene.h"

using namespace muster;
using namespace muster::world;

namespace {

struct Shipped {
  const char* name;
  std::size_t boxes, explorers, inspectors;
};
constexpr Shipped kShipped[] = {
    {"pagoda", 1, 1, 3}, {"temples", 8, 2, 4}, {"town", 10, 4, 8}, {"citadel", 26, 8, 40}};

mission::Mission load(const std::string& name) {
  return mission::Mission::load(std::string(MUSTER_SOURCE_DIR) + "/deploy/missions/" + name +
                                ".yaml");
}

bool overlap(const Box& a, const Box& b) {
  return (a.low().array() < b.high().array()).all() && (b.low().array() < a.high().array()).all();
}

}  // namespace

TEST_CASE("the shipped missions have the papers' sizes and boxes that do not overlap") {
  for (const Shipped& s : kShipped) {
    CAPTURE(s.name);
    const mission::Mission m = load(s.name);
    CHECK(m.boxes.size() == s.boxes);
    CHECK(m.with_role(mission::Role::kStation).size() == 1);
    CHECK(m.with_role(mission::Role::kExplorer).size() == s.explorers);
    CHECK(m.with_role(mission::Role::kInspector).size() == s.inspectors);
    CHECK(m.features.count == 150);
    for (std::size_t i = 0; i < m.boxes.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) CHECK_FALSE(overlap(m.boxes[i], m.boxes[j]));
    }
  }
}

TEST_CASE("robots of the shipped missions start in the open, together and apart enough") {
  for (const Shipped& s : kShipped) {
    CAPTURE(s.name);
    const mission::Mission m = load(s.name);
    const auto scene = Scene::load(m);
    for (const auto& a : m.fleet) {
      CAPTURE(a.id.value);
      CHECK(scene->clearance(a.start.p, 2) > a.vehicle.radius_m);
      double nearest_m = 1e9;
      for (const auto& b : m.fleet) {
        if (a.id == b.id) continue;
        CHECK(scene->line_of_sight(a.start.p, b.start.p));
        nearest_m = std::min(nearest_m, (a.start.p - b.start.p).norm());
      }
      CHECK(nearest_m >= 1.2);
      CHECK(nearest_m <= m.radio.range_m);
      for (const Box& box : m.boxes) CHECK_FALSE(box.contains(a.start.p));
    }
    CHECK(scene->clearance(m.standing.place, 2) > 0.8);
    CHECK(scene->low().head<2>().x() <= m.hull.low().x());
    CHECK(scene->high().head<2>().y() >= m.hull.high().y());
  }
}

TEST_CASE("every box of the shipped missions can be reached, and every feature drawn") {
  for (const char* name : {"temples", "town", "citadel"}) {
    CAPTURE(name);
    const mission::Mission m = load(name);
    const auto scene = Scene::load(m);
    const ReachableSpace reachable(*scene, m);
    for (const Box& box : m.boxes) {
      bool any = false;
      for (const Vec3& corner : box.corners()) {
        any = any || reachable.contains(box.center + 0.95 * (corner - box.center));
      }
      CHECK(any);
    }
    CHECK(draw_features(*scene, m, reachable).features.size() == 150);
  }
}
