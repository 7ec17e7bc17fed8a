#include "commsim/world/vehicle_model.h"

#include <catch2/catch.hpp>

#include "tests/unit/world/fixtures.h"

using namespace muster;
using namespace muster::world;
using namespace muster::world::testing;

namespace {

constexpr Duration kStep{20'000};

struct Flight {
  explicit Flight(const mission::RobotConfig& config, Mesh mesh = ground())
      : scene(std::move(mesh)), vehicle(config, scene) {}

  void until(double t_s) {
    for (; now < SimTime::from_s(t_s); now = now + kStep) {
      const Vec3 v = vehicle.velocity_mps();
      vehicle.step(now, kStep);
      fastest = std::max(fastest, vehicle.velocity_mps().norm());
      hardest = std::max(hardest, (vehicle.velocity_mps() - v).norm() / kStep.s());
    }
  }

  Scene scene;
  VehicleModel vehicle;
  SimTime now;
  double fastest = 0, hardest = 0;
};

mission::Trajectory trajectory(std::vector<mission::TimedState> states, bool land = false) {
  mission::Trajectory t;
  t.states = std::move(states);
  t.land = land;
  return t;
}

const auto kQuad = robot(1, mission::Role::kExplorer, {0, 0, 2});

}  // namespace

TEST_CASE("a trajectory within the limits is followed exactly") {
  Flight f(kQuad);
  const auto states = {state(0, {0, 0, 2}), state(3, {3, 0, 2}, {1, 0, 0}, 1),
                       state(6, {4.5, 0, 3}, {0, 0, 0}, -1)};
  REQUIRE(f.vehicle.command(trajectory(states)));
  for (double t = 0.2; t < 6; t += 0.2) {
    f.until(t);
    const Reference wanted = sample(states, f.now);
    CHECK((f.vehicle.pose().p - wanted.p).norm() < 1e-9);
    CHECK(f.vehicle.pose().yaw_rad == Approx(wanted.yaw_rad).margin(1e-9));
  }
  f.until(8);
  CHECK((f.vehicle.pose().p - Vec3(4.5, 0, 3)).norm() < 1e-6);
  CHECK(f.vehicle.state() == mission::VehicleState::kReady);
}

TEST_CASE("an infeasible trajectory clamps: the vehicle lags within its limits and arrives") {
  Flight f(kQuad);
  REQUIRE(f.vehicle.command(trajectory({state(0, {5, 0, 2}), state(0.5, {12, 3, 4})})));
  f.until(1);
  CHECK(f.vehicle.pose().p.x() < 2);
  f.until(20);
  CHECK((f.vehicle.pose().p - Vec3(12, 3, 4)).norm() < 0.01);
  CHECK(f.fastest <= 2 * 1.03);
  CHECK(f.hardest <= 2 * 1.06);
}

TEST_CASE("a yaw is turned to at the vehicle's rate, the shorter way") {
  Flight f(robot(1, mission::Role::kExplorer, {0, 0, 2}, 3));
  REQUIRE(f.vehicle.command(trajectory({state(0, {0, 0, 2}, {0, 0, 0}, -3)})));
  f.until(0.1);
  CHECK(f.vehicle.pose().yaw_rad == Approx(wrap_angle(3 + 0.1 * 1.5)).margin(1e-6));
  f.until(1);
  CHECK(f.vehicle.pose().yaw_rad == Approx(-3).margin(1e-6));
}

TEST_CASE("an empty trajectory brakes at full deceleration and holds") {
  Flight f(kQuad);
  REQUIRE(f.vehicle.command(trajectory(
      {state(0, {0, 0, 2}), state(1, {1, 0, 2}, {2, 0, 0}), state(3, {5, 0, 2}, {2, 0, 0})})));
  f.until(1.5);
  const double x = f.vehicle.pose().p.x();
  REQUIRE(f.vehicle.command(trajectory({})));
  f.until(4);
  CHECK(f.vehicle.velocity_mps().norm() == 0);
  CHECK(f.vehicle.pose().p.x() - x == Approx(1).margin(0.05));
}

TEST_CASE("landing ends on the ground, and a new trajectory takes off again") {
  Flight f(kQuad);
  REQUIRE(f.vehicle.command(trajectory({state(0, {0, 0, 2}), state(2, {1, 0, 2})}, true)));
  f.until(8);
  CHECK(f.vehicle.state() == mission::VehicleState::kLanded);
  CHECK(f.vehicle.pose().p.z() == Approx(0.26).margin(0.011));
  CHECK_FALSE(f.vehicle.flying());
  REQUIRE(f.vehicle.command(trajectory({})));
  CHECK(f.vehicle.state() == mission::VehicleState::kLanded);
  REQUIRE(f.vehicle.command(trajectory({state(8, f.vehicle.pose().p), state(11, {1, 0, 2})})));
  f.until(12);
  CHECK(f.vehicle.state() == mission::VehicleState::kReady);
  CHECK(f.vehicle.flying());
  CHECK(f.vehicle.pose().p.z() == Approx(2).margin(1e-3));
}

TEST_CASE("a silent process's vehicle flies on for a second, stops, lands and is dead") {
  Flight f(kQuad);
  REQUIRE(f.vehicle.command(trajectory(
      {state(0, {0, 0, 2}), state(1, {1, 0, 2}, {2, 0, 0}), state(6, {11, 0, 2}, {2, 0, 0})})));
  f.until(2);
  f.vehicle.set_alive(false, f.now);
  f.until(2.9);
  CHECK(f.vehicle.velocity_mps().norm() == Approx(2).margin(0.01));
  f.until(12);
  CHECK(f.vehicle.state() == mission::VehicleState::kDead);
  CHECK(f.vehicle.pose().p.x() == Approx(6).margin(0.1));
  CHECK_FALSE(f.vehicle.command(trajectory({state(12, {0, 0, 2})})));
  f.vehicle.set_alive(true, f.now);
  CHECK(f.vehicle.state() == mission::VehicleState::kLanded);
}

TEST_CASE("trajectory times must grow") {
  Flight f(kQuad);
  CHECK_FALSE(f.vehicle.command(trajectory({state(1, {0, 0, 2}), state(1, {1, 0, 2})})));
}

TEST_CASE("a rover keeps its ride height and climbs what it may step on") {
  Mesh mesh = ground();
  add_solid(mesh, {2, -2, 0}, {4, 2, 0.2});
  Flight f(rover(1, {0, 0, 1}), mesh);
  CHECK(f.vehicle.pose().p.z() == Approx(0.4).margin(1e-12));
  REQUIRE(f.vehicle.command(trajectory({state(0, {0, 0, 0.4}), state(4, {3, 0, 0.4})})));
  f.until(6);
  CHECK(f.vehicle.pose().p.x() == Approx(3).margin(0.02));
  CHECK(f.vehicle.pose().p.z() == Approx(0.6).margin(1e-12));
}

TEST_CASE("a rover refuses a step that is too high, and an edge") {
  Mesh mesh = ground();
  add_solid(mesh, {2, -2, 0}, {4, 2, 0.35});
  Flight f(rover(1, {0, 0, 0.4}), mesh);
  REQUIRE(f.vehicle.command(trajectory({state(0, {0, 0, 0.4}), state(4, {3, 0, 0.4})})));
  f.until(10);
  CHECK(f.vehicle.pose().p.x() < 2.01);
  CHECK(f.vehicle.pose().p.z() == Approx(0.4).margin(1e-5));

  Flight edge(rover(1, {18, 0, 0.4}));
  REQUIRE(edge.vehicle.command(trajectory({state(0, {18, 0, 0.4}), state(8, {24, 0, 0.4})})));
  edge.until(10);
  CHECK(edge.vehicle.pose().p.x() <= 20.01);
}
