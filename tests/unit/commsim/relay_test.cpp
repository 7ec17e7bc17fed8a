#include "commsim/relay.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "common/dds/convert.h"

using namespace muster;
using namespace muster::commsim;

namespace {

constexpr RobotId kA{1}, kB{2}, kC{3};

mission::Mission mission_of_three() {
  mission::Mission m;
  for (RobotId id : {kA, kB, kC}) {
    mission::RobotConfig robot;
    robot.id = id;
    m.fleet.push_back(robot);
  }
  return m;
}

mission::Truth truth(std::uint64_t k, const std::vector<Vec3>& places) {
  mission::Truth t;
  t.k = k;
  t.time = time_of_tick(k);
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    t.robots.push_back(
        {RobotId{i + 1}, mission::VehicleState::kMoving, {places[i], 0}, Vec3::Zero()});
  }
  return t;
}

mission::Message beacon(RobotId src, std::uint64_t n) {
  mission::Beacon b;
  b.envelope.n = n;
  b.envelope.src = src;
  return dds::encode(b);
}

mission::Message end(RobotId src, std::uint64_t n) {
  mission::ExchangeEnd e;
  e.envelope.n = n;
  e.envelope.src = src;
  return dds::encode(e);
}

std::vector<std::pair<std::uint32_t, std::uint64_t>> order(
    const std::vector<mission::Message>& messages) {
  std::vector<std::pair<std::uint32_t, std::uint64_t>> out;
  for (const auto& m : messages) {
    const mission::Envelope e = dds::peek_envelope(m.cdr);
    out.emplace_back(e.src.value, e.n);
  }
  return out;
}

bool open_air(const Vec3&, const Vec3&) { return true; }
/// A wall in the plane x = 0.
bool walled(const Vec3& a, const Vec3& b) { return a.x() * b.x() > 0; }

const std::vector<Vec3> kTogether{{1, 0, 1}, {2, 0, 1}, {3, 0, 1}};

}  // namespace

TEST_CASE(
    "everybody in reach hears a message, in the order of sender and number, its bytes untouched") {
  Relay relay(mission_of_three(), open_air);
  const auto out =
      relay.step(truth(1, kTogether), {{kB, {beacon(kB, 4), end(kB, 3)}}, {kA, {beacon(kA, 9)}}});
  CHECK(order(out.deliveries.at(kC)) ==
        std::vector<std::pair<std::uint32_t, std::uint64_t>>{{1, 9}, {2, 3}, {2, 4}});
  CHECK(order(out.deliveries.at(kA)) ==
        std::vector<std::pair<std::uint32_t, std::uint64_t>>{{2, 3}, {2, 4}});
  CHECK(out.deliveries.at(kC)[0].cdr == beacon(kA, 9).cdr);
  CHECK(out.deliveries.at(kC)[1].cls == mission::MessageClass::kExchangeEnd);
}

TEST_CASE("range, walls and death stop a message, and the summary says which") {
  auto mission = mission_of_three();
  Relay relay(mission, walled);
  auto out = relay.step(truth(1, {{1, 0, 1}, {-1, 0, 1}, {9, 0, 1}}), {{kA, {beacon(kA, 1)}}});
  CHECK(out.deliveries.empty());
  relay.set_alive(kB, false);
  out = relay.step(truth(2, kTogether), {{kA, {beacon(kA, 2)}}, {kB, {beacon(kB, 1)}}});
  CHECK(out.deliveries.size() == 1);
  CHECK(out.deliveries.at(kC).size() == 1);
  auto t = truth(3, kTogether);
  t.robots[2].state = mission::VehicleState::kDead;
  relay.set_alive(kB, true);
  out = relay.step(t, {{kA, {beacon(kA, 3)}}});
  CHECK(out.deliveries.at(kB).size() == 1);
  CHECK(out.deliveries.size() == 1);
  const auto air = relay.summary()["air"];
  CHECK(air["dropped"]["range"] == 1);
  CHECK(air["dropped"]["wall"] == 1);
  CHECK(air["dropped"]["dead"] == 4);
  CHECK(air["delivered"] == 2);
  CHECK(air["messages"] == 4);
  CHECK(air["by_topic"]["beacon"]["messages"] == 4);
  CHECK(air["bytes"] == 4 * beacon(kA, 1).cdr.size());
}

TEST_CASE("a pair that is always on hears each other from anywhere") {
  auto mission = mission_of_three();
  mission.radio.always_on = {{kA, kC}};
  Relay relay(mission, walled);
  const auto out =
      relay.step(truth(1, {{-500, 0, 1}, {1, 0, 1}, {500, 0, 1}}), {{kA, {beacon(kA, 1)}}});
  CHECK(out.deliveries.size() == 1);
  CHECK(out.deliveries.at(kC).size() == 1);
}

TEST_CASE("nobody speaks for another, nor on a topic that is not the message's") {
  Relay relay(mission_of_three(), open_air);
  auto wrong_topic = beacon(kA, 2);
  wrong_topic.cls = mission::MessageClass::kPlan;
  mission::Odometry odometry;
  odometry.envelope.src = kA;
  const mission::Message stump{mission::MessageClass::kBeacon, Bytes(10)};
  const auto out = relay.step(truth(1, kTogether),
                              {{kA, {beacon(kB, 1), wrong_topic, dds::encode(odometry), stump}},
                               {RobotId{77}, {beacon(RobotId{77}, 1)}}});
  CHECK(out.deliveries.empty());
  CHECK(relay.summary()["air"]["refused"] == 5);
}

TEST_CASE("a script may take beacons away, and nothing else") {
  auto mission = mission_of_three();
  mission.script.push_back({SimTime::from_s(1), "mute-beacons", kA});
  mission.script.push_back({SimTime::from_s(2), "mute-beacons", kNoRobot});
  Relay relay(mission, open_air);
  const auto heard_by_c = [&](std::uint64_t k) {
    auto out =
        relay.step(truth(k, kTogether), {{kA, {beacon(kA, 1), end(kA, 2)}}, {kB, {beacon(kB, 1)}}});
    return out.deliveries[kC].size();
  };
  CHECK(heard_by_c(9) == 3);
  CHECK(heard_by_c(10) == 2);
  CHECK(heard_by_c(20) == 1);
  CHECK(relay.summary()["air"]["dropped"]["scripted"] == 2 + 4);
}

TEST_CASE("a ray is asked for once per pair, and only within range") {
  int rays = 0;
  Relay relay(mission_of_three(), [&](const Vec3&, const Vec3&) { return ++rays > 0; });
  const std::vector<Vec3> places{{0, 0, 1}, {1, 0, 1}, {100, 0, 1}};
  const std::map<RobotId, std::vector<mission::Message>> chatter{
      {kA, {beacon(kA, 1), end(kA, 2)}}, {kB, {beacon(kB, 1)}}, {kC, {beacon(kC, 1)}}};
  relay.step(truth(1, places), chatter);
  CHECK(rays == 1);
  relay.step(truth(2, places), chatter);
  CHECK(rays == 1);
  relay.step(truth(3, {{0, 0, 1.1}, {1, 0, 1}, {100, 0, 1}}), chatter);
  CHECK(rays == 2);
}

TEST_CASE("contacts are the times in which beacons were heard") {
  Relay relay(mission_of_three(), open_air);
  const std::vector<Vec3> near{{0, 0, 1}, {1, 0, 1}, {100, 0, 1}},
      far{{0, 0, 1}, {50, 0, 1}, {100, 0, 1}};
  for (std::uint64_t k = 0; k < 100; ++k) {
    const bool together = (k >= 10 && k < 30) || (k >= 35 && k <= 40) || k >= 60;
    relay.step(truth(k, together ? near : far), {{kA, {beacon(kA, k)}}});
  }
  const auto contacts = relay.summary()["contacts"];
  REQUIRE(contacts.size() == 1);
  CHECK(contacts[0]["robots"] == nlohmann::json({1, 2}));
  REQUIRE(contacts[0]["intervals"].size() == 2);
  CHECK(contacts[0]["intervals"][0][0] == 1.0);
  CHECK(contacts[0]["intervals"][0][1] == 4.0);
  CHECK(contacts[0]["intervals"][1][0] == 6.0);
  CHECK(contacts[0]["seconds"].get<double>() == Approx(3.0 + 3.9));
}

TEST_CASE("the trace tells any difference in what was sent or heard, and nothing else") {
  const auto trace = [&](const std::vector<Vec3>& places, const mission::Message& a,
                         const mission::Message& b) {
    Relay relay(mission_of_three(), open_air);
    return relay.step(truth(1, places), {{kA, {a, b}}}).trace;
  };
  const auto reference = trace(kTogether, beacon(kA, 1), end(kA, 2));
  CHECK(trace(kTogether, end(kA, 2), beacon(kA, 1)) == reference);
  CHECK(trace({{1, 0, 1}, {2, 0, 1.5}, {3, 0, 1}}, beacon(kA, 1), end(kA, 2)) == reference);
  CHECK(trace({{1, 0, 1}, {20, 0, 1}, {3, 0, 1}}, beacon(kA, 1), end(kA, 2)) != reference);
  CHECK(trace(kTogether, beacon(kA, 1), end(kA, 3)) != reference);
}

TEST_CASE("the true scene decides when it is given") {
  world::Mesh wall;
  wall.vertices = {{0, -10, -10}, {0, 10, -10}, {0, 10, 10}, {0, -10, 10}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  Relay relay(mission_of_three(), std::make_shared<const world::Scene>(wall));
  const auto out =
      relay.step(truth(1, {{-1, 0, 1}, {1, 0, 1}, {-2, 1, 1}}), {{kA, {beacon(kA, 1)}}});
  CHECK(out.deliveries.size() == 1);
  CHECK(out.deliveries.at(kC).size() == 1);
}
