#include "commsim/world/inspection.h"

#include <catch2/catch.hpp>

#include "tests/unit/world/fixtures.h"

using namespace muster;
using namespace muster::world;
using namespace muster::world::testing;

namespace {

/// An inspector 2.5 m in front of a wall at x = 3.
struct Bench {
  explicit Bench(std::vector<Feature> f, bool shared = false) : features(std::move(f)) {
    Mesh mesh = ground();
    add_wall(mesh, 3, -10, 10, 6);
    scene = scene_of(std::move(mesh));
    const auto config = robot(1, mission::Role::kInspector, pose.p);
    mission = mission_of({config});
    mission.inspect.shared = shared;
    camera = std::make_unique<InspectionCamera>(config, mission, features);
    around = std::make_unique<Surroundings>(*scene, std::vector<Body>{});
  }

  std::vector<InspectionCamera::Answer> request(std::uint64_t n, const Vec3& area) {
    mission::Inspect inspect;
    inspect.request = n;
    inspect.area = area;
    inspect.hold_s = 3;
    return camera->request(inspect, now);
  }
  /// Looks every 0.1 s from now until the first answer or for at most `for_s`.
  std::optional<mission::Inspected> wait(double for_s, double speed_mps = 0) {
    for (int i = 0; i < static_cast<int>(std::lround(for_s * 10)); ++i) {
      auto answers = camera->look(*around, pose, speed_mps, now);
      if (!answers.empty()) return answers.front().message;
      now = now + kTick;
    }
    return std::nullopt;
  }

  std::vector<Feature> features;
  std::shared_ptr<const Scene> scene;
  mission::Mission mission;
  std::unique_ptr<InspectionCamera> camera;
  std::unique_ptr<Surroundings> around;
  Pose pose{{0.5, 0, 2}, 0};
  SimTime now;
};

const Vec3 kFront(-1, 0, 0);

}  // namespace

TEST_CASE("an inspection held for t_q finds the feature and carries its image") {
  Bench b({feature(0, {3, 0, 2}, kFront)});
  b.request(7, {3.1, 0.1, 2.05});  // the estimate lies inside the wall
  const auto answer = b.wait(5);
  REQUIRE(answer);
  CHECK(answer->request == 7);
  CHECK(answer->outcome == mission::InspectOutcome::kFound);
  REQUIRE(answer->found.size() == 1);
  CHECK(answer->found[0].feature == FeatureId{0});
  CHECK(answer->payload.size() == 1000);
  CHECK(b.now == SimTime::from_s(3));
}

TEST_CASE("two features within 0.5 m of the area both count") {
  Bench b({feature(0, {3, 0.3, 2}, kFront), feature(1, {3, -0.3, 2}, kFront),
           feature(2, {3, 1, 2}, kFront)});
  b.request(1, {3, 0, 2});
  const auto answer = b.wait(5);
  REQUIRE(answer);
  CHECK(answer->found.size() == 2);
}

TEST_CASE("a decoy answers empty, without an image") {
  Bench b({feature(0, {3, 2, 2}, kFront)});
  b.request(1, {2.9, 0, 2});
  const auto answer = b.wait(5);
  REQUIRE(answer);
  CHECK(answer->outcome == mission::InspectOutcome::kEmpty);
  CHECK(answer->payload.empty());
}

TEST_CASE("an inspection broken by motion starts again") {
  Bench b({feature(0, {3, 0, 2}, kFront)});
  b.request(1, {3, 0, 2});
  CHECK_FALSE(b.wait(2.5));
  CHECK_FALSE(b.wait(0.2, 0.3));
  CHECK_FALSE(b.wait(2.9));
  const auto answer = b.wait(1);
  REQUIRE(answer);
  CHECK(b.now == SimTime::from_s(2.7 + 3));
}

TEST_CASE("an area never in view is refused after t_q + 3 s") {
  Bench b({feature(0, {3, 0, 2}, kFront)});
  SECTION("looking away") { b.pose.yaw_rad = 3; }
  SECTION("too far") { b.pose.p.x() = -2.5; }
  SECTION("from behind") { b.pose = {{5, 0, 2}, 3.14159}; }
  SECTION("too steep") { b.pose = {{2.2, -2.2, 2}, 1.2}; }
  SECTION("behind another robot") {
    b.around = std::make_unique<Surroundings>(*b.scene,
                                              std::vector<Body>{{RobotId{2}, {1.7, 0, 2}, 0.25}});
  }
  b.request(1, {3, 0, 2});
  const auto answer = b.wait(10);
  REQUIRE(answer);
  CHECK(answer->outcome == mission::InspectOutcome::kRefusedView);
  CHECK(b.now == SimTime::from_s(6));
}

TEST_CASE("one camera serves one area: a new request cancels the one before, unless shared") {
  Bench b({feature(0, {3, 0, 2}, kFront)});
  b.request(1, {3, 0, 2});
  const auto cancelled = b.request(2, {3, 0, 2});
  REQUIRE(cancelled.size() == 1);
  CHECK(cancelled[0].message.outcome == mission::InspectOutcome::kCancelled);
  CHECK(cancelled[0].message.request == 1);

  Bench shared({feature(0, {3, 0, 2}, kFront)}, true);
  shared.request(1, {3, 0, 2});
  CHECK(shared.request(2, {3, 0.2, 2}).empty());
  CHECK(shared.request(0, Vec3::Zero()).size() == 2);
}

TEST_CASE("the image depends on seed, robot and area only") {
  const Vec3 area(1, 2, 3);
  CHECK(inspection_payload(1, RobotId{1}, area, 64) == inspection_payload(1, RobotId{1}, area, 64));
  CHECK(inspection_payload(1, RobotId{1}, area, 64) != inspection_payload(1, RobotId{2}, area, 64));
  CHECK(inspection_payload(1, RobotId{1}, area, 64) != inspection_payload(2, RobotId{1}, area, 64));
}
