#include "agent/strategy/view_poses.h"

#include <catch2/catch.hpp>

#include "tests/unit/agent/place.h"

using namespace muster;
using namespace muster::agent;

namespace {

struct Place {
  mission::Mission mission = robot::small_mission();
  robot::Knowledge inspector{mission, RobotId{2}, 1};

  explicit Place(const std::function<bool(const Vec3&)>& solid) {
    reveal(inspector, {-6, -6, 0.1}, {6, 6, 7}, solid);
    be_at(inspector, 1, {0, 0, 2});
    inspector.paths().flood(inspector.position());
  }
  /// A feature at `at` was found by inspecting area `id`.
  void find(std::uint32_t id, const Vec3& at) {
    mission::Inspection i;
    i.area = {RobotId{1}, id};
    i.area_position = at;
    i.found = true;
    i.findings = {{FeatureId{id}, 0, at}};
    inspector.publish(store::RecordClass::kInspection, robot::result_key(i.area), i);
  }
  double incidence(const ViewPose& v, const mission::Area& a, const Vec3& normal) const {
    return std::acos((v.pose.p - a.position).normalized().dot(normal));
  }
};

bool wall(const Vec3& p) { return p.x() > 4.0 && p.x() < 4.4; }
/// A roof that falls towards −x by one in four.
double roof_z(const Vec3& p) { return 4.0 + 0.25 * p.x(); }
bool roof(const Vec3& p) { return std::abs(p.z() - roof_z(p)) < 0.15; }

}  // namespace

TEST_CASE("the spot to ask about is moved off what is known, as little as that takes") {
  Place p(wall);
  const mission::Area a = area_at({4.0, 0, 2}, {2.0, 0, 2});
  CHECK(spot_to_ask(p.inspector, a) == a.position);
  const double off_m = GENERATE(0.2, 0.35);
  p.find(1, {4.0, off_m, 2});
  const Vec3 spot = spot_to_ask(p.inspector, a);
  CHECK((spot - Vec3(4.0, off_m, 2)).norm() > p.mission.inspect.match_m);
  CHECK((spot - Vec3(4.0, off_m - 0.52, 2)).norm() < 0.01);
  CHECK_FALSE(known_near(p.inspector, spot));
  // Between two there is no such spot.
  p.find(2, {4.0, -off_m, 2});
  p.find(3, {4.0, 0, 2.2});
  p.find(4, {4.0, 0, 1.8});
  p.find(5, {3.8, 0, 2});
  CHECK(spot_to_ask(p.inspector, a) == a.position);
}

TEST_CASE("asked about in vain beside a known feature, the spot turns around that feature") {
  Place p(wall);
  mission::Area a = area_at({4.0, 0, 2}, {2.0, 0, 2});
  a.normal = -Vec3::UnitX();
  const Vec3 feature(4.0, 0.2, 2);
  p.find(1, feature);
  const Vec3 first = spot_to_ask(p.inspector, a, 0), up = spot_to_ask(p.inspector, a, 1),
             down = spot_to_ask(p.inspector, a, 2);
  for (const Vec3& spot : {first, up, down}) {
    CHECK_FALSE(known_near(p.inspector, spot));
    CHECK((spot - a.position).norm() < p.mission.inspect.match_m);
  }
  CHECK(std::abs(up.z() - down.z()) > p.mission.inspect.match_m);
  CHECK(spot_to_ask(p.inspector, a, 3) == first);
}

TEST_CASE("a wall sighted from the side is looked at within the rule's incidence") {
  Place p(wall);
  const mission::Area a = area_at({4.0, 0, 2}, {2.0, 4.0, 2.2});
  const auto v = view_pose(p.inspector, a, {}, 0);
  REQUIRE(v);
  CHECK(p.incidence(*v, a, -Vec3::UnitX()) < p.mission.inspect.max_incidence_rad);
  CHECK(v->probability > 0.8);
  CHECK(in_sight(p.inspector, a, v->pose));
}

TEST_CASE("a shallow roof is looked at from high up, on the side to which it falls") {
  Place p(roof);
  be_at(p.inspector, 1, {-4, 0, 5});
  p.inspector.paths().flood(p.inspector.position());
  const Vec3 spot(-2, 0, 3.5);
  const mission::Area a = area_at(spot, {-4, 2.5, 5.2});
  const auto v = view_pose(p.inspector, a, {}, 0);
  REQUIRE(v);
  const Vec3 normal = Vec3(-0.25, 0, 1).normalized();
  CHECK(p.incidence(*v, a, normal) < p.mission.inspect.max_incidence_rad + 0.03);
  CHECK(v->pose.p.x() < spot.x());
}

TEST_CASE("after a refusal the surface is believed to face elsewhere") {
  Place p([](const Vec3&) { return false; });
  const mission::Area a = area_at({0, 0, 2}, {-3, 0, 2});
  SurfaceBelief belief(p.inspector.map(), a, p.mission.inspect, p.inspector.config().vehicle);
  const Vec3 west = -Vec3::UnitX(), north = Vec3(-0.3, 1, 0).normalized();
  const double west_before = belief.faces(west), north_before = belief.faces(north);
  CHECK(west_before > north_before);
  belief.refuse({west, 2});
  CHECK(belief.faces(west) < west_before);
  CHECK(belief.faces(north) > north_before);
}

TEST_CASE("what the map says of a surface is given up when looks that believed it are refused") {
  Place p(wall);
  const mission::Area a = area_at({4.0, 0, 2}, {2.0, 0, 3.0});
  SurfaceBelief belief(p.inspector.map(), a, p.mission.inspect, p.inspector.config().vehicle);
  const Vec3 up = Vec3(-0.2, 0, 1).normalized();
  CHECK(belief.faces(up) < 0.1);
  for (const double y : {0.0, 0.4, -0.4, 0.9, -0.9, 1.4, -1.4})
    belief.refuse({Vec3(-1, y, 0).normalized(), 2});
  CHECK(belief.faces(up) > 0.5);
}

TEST_CASE("what cannot be seen from anywhere has no pose, and a wall in between hides an area") {
  Place p([](const Vec3& q) { return wall(q) || (q.x() > 3.0 && q.x() < 3.4); });
  CHECK_FALSE(view_pose(p.inspector, area_at({4.0, 0, 2}, {3.7, 0, 2}), {}, 0));
  CHECK_FALSE(in_sight(p.inspector, area_at({4.0, 0, 2}, {3.7, 0, 2}), {{1, 0, 2}, 0}));
}

TEST_CASE("an area close to the limit of the field of view is looked at from further away") {
  Place p([](const Vec3&) { return false; });
  const mission::Area a = area_at({0, 0, 2}, {-3, 0, 2});
  SurfaceBelief belief(p.inspector.map(), a, p.mission.inspect, p.inspector.config().vehicle);
  const Vec3 steep(-std::cos(0.48), 0, std::sin(0.48));
  CHECK(belief.in_view(steep, 3.5) > belief.in_view(steep, 1.2));
  CHECK(belief.in_view(-Vec3::UnitX(), 2) > 0.98);
  CHECK(belief.in_view(-Vec3::UnitX(), 5.2) < 0.1);
}
