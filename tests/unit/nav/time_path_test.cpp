#include <rapidcheck.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "common/core/random.h"
#include "common/nav/trajectory.h"

using namespace muster;
using namespace muster::nav;

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kStep_s = 0.02;

Path polyline(std::vector<Vec3> points) { return Path{std::move(points)}; }

Path random_polyline(Random& random, std::size_t corners, double longest, bool flat) {
  Path path;
  Vec3 p = Vec3::Zero();
  path.points.push_back(p);
  for (std::size_t i = 0; i <= corners; ++i) {
    Vec3 d(random.normal(), random.normal(), flat ? 0 : random.normal());
    p += d.normalized() * random.uniform(0.05, longest);
    path.points.push_back(p);
  }
  return path;
}

double distance_to(const Path& path, const Vec3& p) {
  double best = 1e9;
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    const Vec3 a = path.points[i - 1], d = path.points[i] - a;
    const double u = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    best = std::min(best, (a + u * d - p).norm());
  }
  return best;
}

/// What a trajectory did at its worst, seen at 50 Hz.
struct Worst {
  double speed = 0, accel = 0, yaw_rate = 0, off_path = 0, jump = 0;
  double blind_speed = 0;  ///< level speed while the camera is more than 52° off the motion
};
Worst observe(const Trajectory& trajectory, const Path& path) {
  Worst worst;
  State last = trajectory.at(trajectory.start());
  for (SimTime t = trajectory.start() + Duration::from_s(kStep_s); t < trajectory.end();
       t = t + Duration::from_s(kStep_s)) {
    const State s = trajectory.at(t);
    worst.speed = std::max(worst.speed, s.v_mps.norm());
    worst.accel = std::max(worst.accel, (s.v_mps - last.v_mps).norm() / kStep_s);
    worst.yaw_rate =
        std::max(worst.yaw_rate, std::abs(wrap_angle(s.yaw_rad - last.yaw_rad)) / kStep_s);
    worst.jump = std::max(worst.jump, (s.p - last.p - (s.v_mps + last.v_mps) / 2 * kStep_s).norm());
    if (!path.points.empty()) worst.off_path = std::max(worst.off_path, distance_to(path, s.p));
    const double level = s.v_mps.head<2>().norm();
    if (level > 1e-3 && std::abs(s.v_mps.z()) < level) {
      const double off = wrap_angle(std::atan2(s.v_mps.y(), s.v_mps.x()) - s.yaw_rad);
      if (std::abs(off) > 52 * kPi / 180)
        worst.blind_speed = std::max(worst.blind_speed, s.v_mps.norm());
    }
    last = s;
  }
  return worst;
}

void check_limits(const Worst& worst, const Limits& limits) {
  CHECK(worst.speed <= limits.speed_mps * 1.02);
  CHECK(worst.accel <= limits.accel_mps2 * 1.02);
  CHECK(worst.yaw_rate <= limits.yaw_rate_radps * 1.02);
  CHECK(worst.jump <= 1e-3);
}

TimingRequest at_rest(const Path& path, double yaw = 0) {
  TimingRequest request;
  request.now.t = SimTime::from_s(12.3);
  request.now.p = path.points.front();
  request.now.yaw_rad = yaw;
  return request;
}

}  // namespace

TEST_CASE("a straight from rest to rest takes hardly more than the least possible time") {
  const Limits limits;
  const auto path = polyline({Vec3(0, 0, 1), Vec3(10, 0, 1)});
  const auto trajectory = time_path(path, at_rest(path), limits);
  CHECK((trajectory.end() - trajectory.start()).s() ==
        Approx(travel_time_s(10, limits)).margin(0.03));
  CHECK(trajectory.states().size() == 4);
  CHECK((trajectory.states().back().p - Vec3(10, 0, 1)).norm() < 1e-4);
  CHECK(travel_time_s(1, limits) == Approx(std::sqrt(2.0)));
}

TEST_CASE("limits hold at 50 Hz on random polylines, which end at rest at their last point") {
  const auto whatever = [] {
    const auto seed = *rc::gen::arbitrary<std::uint32_t>();
    Random random(seed, RobotId{0}, "polyline");
    const Limits limits;
    const bool flat = random.chance(0.5);
    const Path path = random_polyline(random, random.below(10), random.chance(0.5) ? 0.8 : 6, flat);
    auto request = at_rest(path, random.uniform(-kPi, kPi));
    if (random.chance(0.5)) request.final_yaw_rad = random.uniform(-kPi, kPi);
    request.look_ahead = random.chance(0.5);
    const double corner = random.uniform(0.05, 0.2);
    const auto trajectory = time_path(path, request, limits, corner);
    const Worst worst = observe(trajectory, path);
    RC_ASSERT(worst.speed <= limits.speed_mps * 1.02);
    RC_ASSERT(worst.accel <= limits.accel_mps2 * 1.02);
    RC_ASSERT(worst.yaw_rate <= limits.yaw_rate_radps * 1.02);
    RC_ASSERT(worst.jump <= 1e-3);
    RC_ASSERT(worst.off_path <= corner + 1e-3);
    const State& last = trajectory.states().back();
    RC_ASSERT(last.v_mps.norm() == 0.0);
    RC_ASSERT((last.p - path.points.back()).norm() < 2e-3);
    if (request.final_yaw_rad) {
      RC_ASSERT(std::abs(wrap_angle(last.yaw_rad - *request.final_yaw_rad)) < 1e-3);
    }
    if (request.look_ahead && path.length_m() >= 1) RC_ASSERT(worst.blind_speed <= 0.52);
  };
  CHECK(rc::check("limits", whatever));
}

TEST_CASE("limits hold from any present velocity, which stays continuous") {
  const auto whatever = [] {
    const auto seed = *rc::gen::arbitrary<std::uint32_t>();
    Random random(seed, RobotId{0}, "moving");
    const Limits limits;
    const Path path = random_polyline(random, random.below(6), 4, random.chance(0.5));
    auto request = at_rest(path, 0);
    const Vec3 first = (path.points[1] - path.points[0]).normalized();
    const Vec3 off(random.normal(), random.normal(), random.normal());
    request.now.v_mps =
        (first + off * (random.chance(0.6) ? 0.1 : 2)).normalized() * random.uniform(0, 2);
    request.now.yaw_rad =
        std::atan2(request.now.v_mps.y(), request.now.v_mps.x()) + random.uniform(-0.8, 0.8);
    const auto trajectory = time_path(path, request, limits);
    const State& start = trajectory.states().front();
    RC_ASSERT((start.v_mps - request.now.v_mps).norm() < 1e-9);
    RC_ASSERT((start.p - request.now.p).norm() < 1e-9);
    const Worst worst = observe(trajectory, path);
    RC_ASSERT(worst.speed <= limits.speed_mps * 1.02);
    RC_ASSERT(worst.accel <= limits.accel_mps2 * 1.02);
    RC_ASSERT(worst.yaw_rate <= limits.yaw_rate_radps * 1.02);
    RC_ASSERT(worst.jump <= 1e-3);
    RC_ASSERT(trajectory.states().back().v_mps.norm() == 0.0);
    RC_ASSERT((trajectory.states().back().p - path.points.back()).norm() < 2e-3);
  };
  CHECK(rc::check("moving", whatever));
}

TEST_CASE("a vehicle that is replanned along its way does not brake for it") {
  const Limits limits;
  const auto path = polyline({Vec3(0, 0, 1), Vec3(8, 0, 1), Vec3(8, 8, 1), Vec3(16, 8, 1)});
  const auto whole = time_path(path, at_rest(path), limits);
  for (double t = 0.3; t < (whole.end() - whole.start()).s(); t += 0.3) {
    const State now = whole.at(whole.start() + Duration::from_s(t));
    Path rest;
    rest.points.push_back(now.p);
    for (const Vec3& p : path.points) {
      // What lies ahead on an ascending staircase.
      if (p.x() + p.y() > now.p.x() + now.p.y() + 0.3) rest.points.push_back(p);
    }
    if (rest.points.size() < 2) rest.points.push_back(path.points.back());
    TimingRequest request;
    request.now = now;
    const auto again = time_path(rest, request, limits);
    INFO("at " << t << " p " << now.p.transpose() << " v " << now.v_mps.transpose());
    CHECK(again.end().s() <= whole.end().s() + 0.6);
    check_limits(observe(again, {}), limits);
  }
}

TEST_CASE("the camera looks along the way before the vehicle is fast, also through sharp corners") {
  const Limits limits;
  const auto path = polyline({Vec3(0, 0, 1), Vec3(6, 0, 1), Vec3(0, 1, 1), Vec3(0, 6, 1)});
  for (double yaw = -3; yaw <= 3; yaw += 0.5) {
    const auto trajectory = time_path(path, at_rest(path, yaw), limits);
    const Worst worst = observe(trajectory, path);
    check_limits(worst, limits);
    CHECK(worst.blind_speed <= 0.52);
    CHECK(worst.speed > 1.5);
  }
}

TEST_CASE("a move shorter than a metre does not wait for the camera") {
  const Limits limits;
  const auto path = polyline({Vec3(0, 0, 1), Vec3(-0.8, 0, 1)});
  const auto trajectory = time_path(path, at_rest(path, 0), limits);
  CHECK((trajectory.end() - trajectory.start()).s() ==
        Approx(travel_time_s(0.8, limits)).margin(0.03));
}

TEST_CASE("a camera that need not look ahead turns on the way") {
  const Path path = polyline({{0, 0, 0}, {0, 3, 0}, {0, 3, 2}});
  TimingRequest request = at_rest(path);
  request.final_yaw_rad = -kPi / 2;
  const auto seconds = [&] {
    const Trajectory t = time_path(path, request, Limits{});
    return (t.end() - t.start()).s();
  };
  const double looking_ahead_s = seconds();
  request.look_ahead = false;
  CHECK(seconds() < 0.65 * looking_ahead_s);
  CHECK(seconds() < 1.25 * travel_time_s(5, Limits{}));  // it has a corner, too
}

TEST_CASE("steep climbs are slow, and never faster than sight allows") {
  const Limits limits;
  const auto climb = polyline({Vec3(0, 0, 1), Vec3(2, 0, 8)});
  CHECK(observe(time_path(climb, at_rest(climb), limits), climb).speed <= 1.001);
  const auto path = polyline({Vec3(0, 0, 1), Vec3(20, 0, 1)});
  const auto short_sighted = time_path(path, at_rest(path), limits, 0.1, 0.5);
  const double v = observe(short_sighted, path).speed;
  CHECK(v * v / (2 * limits.accel_mps2) + 0.2 * v <= 0.501);
  auto slow = at_rest(path);
  slow.speed_scale = 0.25;
  CHECK(observe(time_path(path, slow, limits), path).speed == Approx(0.5));
}

TEST_CASE("a ground vehicle drives where it looks and turns in place at sharp corners") {
  Limits limits;
  limits.ground = true;
  Random random(3, RobotId{0}, "ground");
  for (int trial = 0; trial < 50; ++trial) {
    const auto path = random_polyline(random, random.below(8), 5, true);
    const auto trajectory = time_path(path, at_rest(path, random.uniform(-kPi, kPi)), limits);
    check_limits(observe(trajectory, path), limits);
    for (SimTime t = trajectory.start(); t < trajectory.end(); t = t + Duration::from_s(0.02)) {
      const State s = trajectory.at(t);
      CHECK(s.v_mps.z() == 0);
      if (s.v_mps.norm() < 0.01) continue;
      const double heading = std::atan2(s.v_mps.y(), s.v_mps.x());
      CHECK(std::abs(wrap_angle(heading - s.yaw_rad)) < 0.15);
    }
    CHECK((trajectory.states().back().p - path.points.back()).norm() < 2e-3);
  }
}

TEST_CASE("a path without length only turns") {
  const Limits limits;
  const auto path = polyline({Vec3(1, 2, 3)});
  auto request = at_rest(path, 0.5);
  CHECK(time_path(path, request, limits).states().size() == 1);
  request.final_yaw_rad = 2.0;
  const auto turn = time_path(path, request, limits);
  CHECK((turn.end() - turn.start()).s() == Approx(1).margin(1e-3));
  CHECK(turn.states().back().yaw_rad == Approx(2));
  CHECK(time_path({}, request, limits).states().back().p == Vec3(1, 2, 3));
}

TEST_CASE("braking is at full deceleration along the velocity") {
  const Limits limits;
  State now;
  now.v_mps = Vec3(0, -1.6, 1.2);
  const auto halt = stop(now, limits);
  CHECK((halt.end() - halt.start()).s() == Approx(1));
  CHECK((halt.states().back().p - Vec3(0, -0.8, 0.6)).norm() < 1e-5);
  CHECK(halt.states().back().v_mps.norm() == 0);
  now.v_mps.setZero();
  CHECK(stop(now, limits).states().size() == 1);
}

TEST_CASE("a trajectory stands before its start and hovers after its end") {
  State a, b;
  a.t = SimTime::from_s(1);
  b.t = SimTime::from_s(3);
  b.p = Vec3(2, 0, 0);
  a.yaw_rad = 3.0;
  b.yaw_rad = -3.0;
  const Trajectory trajectory({a, b});
  CHECK(trajectory.at(SimTime::from_s(0)).p == a.p);
  CHECK(trajectory.at(SimTime::from_s(2)).p.x() == Approx(1));
  CHECK(std::abs(trajectory.at(SimTime::from_s(2)).yaw_rad) == Approx(kPi));
  CHECK(trajectory.at(SimTime::from_s(9)).p == b.p);
  CHECK(trajectory.at(SimTime::from_s(9)).v_mps.norm() == 0);
}
