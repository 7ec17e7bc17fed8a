#include "commsim/relay.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "common/dds/convert.h"
#include "commsim/walls.h"

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

TEST_CASE("inside a jammed sphere nobody hears or is heard, while it lasts") {
  auto mission = mission_of_three();
  mission::ScriptedEvent jam{SimTime::from_s(1), "jam"};
  jam.center = {3, 0, 1};
  jam.radius_m = 0.5;
  jam.lasts = Duration::from_s(1);
  mission.script.push_back(jam);
  Relay relay(mission, open_air);
  const auto heard = [&](std::uint64_t k) {
    const auto out =
        relay.step(truth(k, kTogether), {{kA, {beacon(kA, 1)}}, {kC, {beacon(kC, 1)}}});
    return out.deliveries.size();
  };
  CHECK(heard(9) == 3);   // b hears both, they each other
  CHECK(heard(10) == 1);  // b hears a
  CHECK(heard(19) == 1);
  CHECK(heard(20) == 3);
  CHECK(relay.summary()["air"]["dropped"]["jam"] == 6);
}

TEST_CASE("a cut pair hears others, but not each other") {
  auto mission = mission_of_three();
  mission::ScriptedEvent cut{SimTime::from_s(1), "cut", kC};
  cut.other = kA;
  cut.lasts = Duration::from_s(1);
  mission.script.push_back(cut);
  Relay relay(mission, open_air);
  const auto out = relay.step(truth(10, kTogether), {{kA, {beacon(kA, 1)}}, {kC, {beacon(kC, 1)}}});
  CHECK(out.deliveries.size() == 1);
  CHECK(out.deliveries.at(kB).size() == 2);
  CHECK(relay.summary()["air"]["dropped"]["cut"] == 2);
}

TEST_CASE("loss rises to what the script says, and falls back") {
  auto mission = mission_of_three();
  mission::ScriptedEvent loss{SimTime::from_s(10), "loss"};
  loss.value = 0.5;
  loss.lasts = Duration::from_s(50);
  mission.script.push_back(loss);
  Relay relay(mission, open_air);
  std::uint64_t lost = 0;
  for (std::uint64_t k = 0; k < 700; ++k) {
    relay.step(truth(k, kTogether), {{kA, {beacon(kA, k + 1)}}});
    const auto now = relay.summary()["air"]["dropped"]["loss"].get<std::uint64_t>();
    if (k < 100 || k >= 600) CHECK(now == lost);
    lost = now;
  }
  CHECK(lost > 400);
  CHECK(lost < 600);
}

TEST_CASE(
    "who is paused hears nothing, and that is the reason, whoever dropped it from the barrier") {
  auto mission = mission_of_three();
  mission::ScriptedEvent pause{SimTime::from_s(1), "pause", kB};
  pause.lasts = Duration::from_s(1);
  mission.script.push_back(pause);
  Relay relay(mission, open_air), told(mission, open_air);
  told.set_alive(kB, false);
  for (Relay* r : {&relay, &told}) {
    const auto out = r->step(truth(10, kTogether), {{kA, {beacon(kA, 1)}}});
    CHECK(out.deliveries.size() == 1);
    CHECK(r->summary()["air"]["dropped"]["paused"] == 1);
  }
  told.set_alive(kB, true);
  CHECK(told.step(truth(20, kTogether), {{kA, {beacon(kA, 2)}}}).deliveries.size() == 2);
}

TEST_CASE("whose place nobody knows is unheard and hears nothing, and that is the reason") {
  Relay relay(mission_of_three(), open_air);
  relay.set_located(kB, false);
  const auto out = relay.step(truth(1, kTogether), {{kA, {beacon(kA, 1)}}, {kB, {beacon(kB, 1)}}});
  CHECK(out.deliveries.size() == 1);
  CHECK(relay.summary()["air"]["dropped"]["pose"] == 3);
  relay.set_located(kB, true);
  CHECK(relay.step(truth(2, kTogether), {{kB, {beacon(kB, 2)}}}).deliveries.size() == 2);
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

TEST_CASE("who was apart for long meets anew, and a meeting's bytes are what came through") {
  Relay relay(mission_of_three(), open_air);
  const std::vector<Vec3> near{{0, 0, 1}, {1, 0, 1}, {100, 0, 1}},
      far{{0, 0, 1}, {50, 0, 1}, {100, 0, 1}};
  std::vector<std::uint64_t> met;
  for (std::uint64_t k = 0; k < 500; ++k) {
    const bool together = k < 10 || (k >= 30 && k < 40) || k >= 400;
    const auto sent =
        k % 2 == 0 ? std::vector{beacon(kA, k)} : std::vector{beacon(kA, k), end(kA, k + 1000)};
    const auto outcome = relay.step(truth(k, together ? near : far), {{kA, sent}});
    for (const auto& pair : outcome.met) {
      CHECK(pair == std::pair(kA, kB));
      met.push_back(k);
    }
  }
  CHECK(met == std::vector<std::uint64_t>{0, 400});
  const auto contact = relay.summary()["contacts"][0];
  CHECK(contact["meetings"] == 2);
  CHECK(contact["intervals"].size() == 3);
  CHECK(contact["bytes"] == relay.summary()["air"]["delivered_bytes"]);
  CHECK(contact["map_bytes"] == 0);
  CHECK(contact["data_seconds"].get<double>() == Approx(6));
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

TEST_CASE("where the air is shared beacons go first, and what the air does not hold is dropped") {
  auto mission = mission_of_three();
  mission.radio.bit_rate_mbps = 0.1;  // 1250 bytes in a tick
  mission.radio.queue_ms = 80;
  Relay relay(mission, open_air);
  std::vector<mission::Message> many;
  for (std::uint64_t n = 1; n < 100; ++n) many.push_back(end(kA, n));
  const std::size_t bytes = many[0].cdr.size();
  many.push_back(beacon(kA, 100));
  const auto out = relay.step(truth(1, kTogether), {{kA, many}, {kB, {end(kB, 1)}}});
  const auto heard = order(out.deliveries.at(kC));
  CHECK(std::ranges::count(heard, std::pair<std::uint32_t, std::uint64_t>(1, 100)) == 1);
  CHECK(std::ranges::count(heard, std::pair<std::uint32_t, std::uint64_t>(2, 1)) == 1);
  CHECK(heard.size() > 3);
  CHECK(heard.size() * bytes < 1250 + bytes);
  CHECK(std::ranges::is_sorted(heard));
  CHECK(relay.summary()["air"]["dropped"]["airtime"] > 100);
  CHECK(relay.summary()["air"]["dropped"]["range"] == 0);
}

TEST_CASE("what takes longer than a tick is heard in a later one, in order, if one still lives") {
  auto mission = mission_of_three();
  mission.radio.latency_ms = 250;
  Relay relay(mission, open_air);
  CHECK(relay.step(truth(1, kTogether), {{kA, {beacon(kA, 1)}}}).deliveries.empty());
  CHECK(relay.step(truth(2, kTogether), {{kB, {beacon(kB, 1)}}}).deliveries.empty());
  // Sent at 0.1 s, on the ears at 0.35 s: heard in tick 4, the one after this.
  auto out = relay.step(truth(3, kTogether), {});
  CHECK(order(out.deliveries.at(kC)) ==
        std::vector<std::pair<std::uint32_t, std::uint64_t>>{{1, 1}});
  relay.set_alive(kC, false);
  out = relay.step(truth(4, kTogether), {});
  CHECK(out.deliveries.size() == 1);
  CHECK(out.deliveries.contains(kA));
  CHECK(relay.summary()["air"]["dropped"]["dead"] == 1);
  CHECK(relay.summary()["air"]["delivered"] == 3);
}

TEST_CASE("the second radio brings what the first does not, hop by hop") {
  auto mission = mission_of_three();
  mission.radio.mesh = radio::MeshConfig{"paper", {.range_m = 50, .line_of_sight = false}, 1};
  const std::vector<Vec3> row{{0, 0, 1}, {40, 0, 1}, {80, 0, 1}};
  Relay one_hop(mission, walled);
  auto out = one_hop.step(truth(1, row), {{kA, {beacon(kA, 1)}}});
  CHECK(out.deliveries.contains(kB));
  CHECK_FALSE(out.deliveries.contains(kC));
  CHECK(one_hop.summary()["air"]["by_mesh"] == 1);
  CHECK(one_hop.summary()["air"]["dropped"]["range"] == 1);
  mission.radio.mesh->hops = 2;
  Relay two_hops(mission, walled);
  out = two_hops.step(truth(1, row), {{kA, {beacon(kA, 1)}}});
  CHECK(out.deliveries.at(kC).size() == 1);
  two_hops.set_alive(kB, false);
  CHECK(two_hops.step(truth(2, row), {{kA, {beacon(kA, 2)}}}).deliveries.empty());
}

TEST_CASE("a lossy radio loses a share, counted, the same in every run") {
  auto mission = mission_of_three();
  mission.radio.loss = 0.3;
  const auto fly = [&] {
    Relay relay(mission, open_air);
    std::uint64_t traces = 0;
    for (std::uint64_t k = 1; k <= 500; ++k) {
      traces ^= relay.step(truth(k, kTogether), {{kA, {beacon(kA, k)}}}).trace;
    }
    return std::pair(traces, relay.summary()["air"]["dropped"]["loss"].get<int>());
  };
  const auto [trace, lost] = fly();
  CHECK(lost / 1000.0 == Approx(0.3).margin(0.05));
  CHECK(fly() == std::pair(trace, lost));
  mission.seed = 2;
  CHECK(fly().first != trace);
}

TEST_CASE("a line crosses a solid once and a sheet once, whichever way it goes") {
  world::Mesh mesh;
  const auto sheet = [&](float x, bool towards_minus) {
    const int i = static_cast<int>(mesh.vertices.size());
    for (const auto& [y, z] : {std::pair{-9.f, -9.f}, {9.f, -9.f}, {9.f, 9.f}, {-9.f, 9.f}}) {
      mesh.vertices.emplace_back(x, y, z);
    }
    const int b = towards_minus ? 2 : 1, c = towards_minus ? 1 : 2;
    mesh.triangles.emplace_back(i, i + b, i + c);
    mesh.triangles.emplace_back(i, i + b + 1, i + c + 1);
  };
  sheet(0, true), sheet(0.2f, false);  // a wall of 20 cm
  sheet(5, true), sheet(5.2f, false);  // another
  sheet(9, true);                      // a screen
  const world::Scene scene(mesh);
  const Vec3 left(-1, 0.3, 0.1), middle(3, 0.3, 0.1), right(11, 0.3, 0.1);
  CHECK(walls_between(scene, left, middle) == 1);
  CHECK(walls_between(scene, middle, left) == 1);
  CHECK(walls_between(scene, left, right) == 3);
  CHECK(walls_between(scene, right, left) == 3);
  CHECK(walls_between(scene, left, left + Vec3(0, 1, 0)) == 0);
  CHECK(walls_between(scene, left, left) == 0);
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
