#include "commsim/world/collision.h"

#include <catch2/catch.hpp>

#include "tests/unit/world/fixtures.h"

using namespace muster;
using namespace muster::world;
using namespace muster::world::testing;

namespace {

MovingBody quad(std::uint32_t id, const Vec3& p) { return {RobotId{id}, p, 0.25, false, true, {}}; }

}  // namespace

TEST_CASE("a contact with a wall counts once until 5 cm apart") {
  Mesh mesh = ground();
  add_wall(mesh, 3, -10, 10, 6);
  const Scene scene(mesh);
  CollisionChecker checker(scene);
  std::size_t contacts = 0;
  const auto fly = [&](double from, double to) {
    const double step = from < to ? 0.04 : -0.04;
    const int n = static_cast<int>(std::lround((to - from) / step));
    for (int i = 0; i <= n; ++i) {
      contacts += checker.step({quad(1, {from + i * step, 0, 2})}).size();
    }
  };
  fly(0, 2.72);
  CHECK(contacts == 0);
  CHECK(*checker.min_clearance_m() == Approx(0.03).margin(0.02));
  fly(2.72, 2.88);
  CHECK(contacts == 1);
  fly(2.88, 2.72);
  fly(2.72, 2.88);
  CHECK(contacts == 1);
  fly(2.88, 2.4);
  fly(2.4, 2.88);
  CHECK(contacts == 2);
}

TEST_CASE("bodies that touch count once until 5 cm apart") {
  const Scene scene(ground());
  CollisionChecker checker(scene);
  CHECK(checker.step({quad(1, {0, 0, 2}), quad(2, {1, 0, 2})}).empty());
  const auto contacts = checker.step({quad(1, {0, 0, 2}), quad(2, {0.49, 0, 2})});
  REQUIRE(contacts.size() == 1);
  CHECK(contacts[0].other == RobotId{2});
  CHECK(checker.step({quad(1, {0, 0, 2}), quad(2, {0.52, 0, 2})}).empty());
  CHECK(checker.step({quad(1, {0, 0, 2}), quad(2, {0.49, 0, 2})}).empty());
  CHECK(checker.step({quad(1, {0, 0, 2}), quad(2, {0.56, 0, 2})}).empty());
  CHECK(checker.step({quad(1, {0, 0, 2}), quad(2, {0.49, 0, 2})}).size() == 1);
  CHECK(*checker.min_separation_m() == Approx(-0.01));
}

TEST_CASE("standing on the ground and driving over it are no collisions") {
  Mesh mesh = ground();
  add_solid(mesh, {2, -2, 0}, {4, 2, 0.2});
  const Scene scene(mesh);
  CollisionChecker checker(scene);
  MovingBody landed = quad(1, {0, 0, 0.2});
  landed.resting = true;
  landed.flying = false;
  MovingBody rover{RobotId{2}, {1.85, 0, 0.4}, 0.25, false, false, 0.25};
  CHECK(checker.step({landed, rover}).empty());
  CHECK_FALSE(checker.min_clearance_m());
  rover.footing_z.reset();  // the same place without the excuse
  CHECK(checker.step({landed, rover}).size() == 1);
}
