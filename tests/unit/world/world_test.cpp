#include "commsim/world/world.h"

#include <catch2/catch.hpp>

#include "common/core/error.h"
#include "tests/unit/world/fixtures.h"

using namespace muster;
using namespace muster::world;
using namespace muster::world::testing;
using mission::MessageClass;
using mission::Role;

namespace {

const Vec3 kFront(-1, 0, 0);

Mesh walled() {
  Mesh mesh = ground();
  add_wall(mesh, 3, -10, 10, 6);
  return mesh;
}

mission::Mission small_fleet() {
  return mission_of({rover(0, {-6, 0, 0.4}), robot(1, Role::kExplorer, {0, 0, 2}),
                     robot(2, Role::kInspector, {0.5, 2, 2})});
}

FeatureSet two_features() {
  FeatureSet set;
  set.features = {feature(0, {3, 2, 2}, kFront), feature(1, {3, 0, 2}, kFront)};
  set.decoys = {feature(0, {3, -1, 2}, kFront, false)};
  return set;
}

World make_world(const mission::Mission& m) {
  return World(m, scene_of(walled()), two_features(), {});
}

mission::Trajectory to(const Vec3& from_p, const Vec3& p, double t_s, double for_s) {
  mission::Trajectory t;
  t.states = {state(t_s, from_p), state(t_s + for_s, p)};
  return t;
}

mission::Inspect inspect(std::uint64_t n, const Vec3& area) {
  mission::Inspect i;
  i.request = n;
  i.area = area;
  i.hold_s = 3;
  return i;
}

mission::ScriptedEvent lasting(double at_s, const char* verb, RobotId robot, double for_s) {
  mission::ScriptedEvent e{SimTime::from_s(at_s), verb, robot};
  e.lasts = Duration::from_s(for_s);
  return e;
}

const mission::TrueState& true_state(const mission::Truth& truth, std::uint32_t id) {
  for (const auto& r : truth.robots) {
    if (r.robot == RobotId{id}) return r;
  }
  throw std::logic_error("no such robot");
}

/// At tick 60 the process of robot 2, which has been silent, finds it landed, and flies it until
/// tick 100.
void find_landed_and_fly(World& world) {
  const auto samples = world.begin_tick(60);
  const auto odometry = all_of<mission::Odometry>(samples, 2, MessageClass::kOdometry);
  REQUIRE(odometry.size() == 1);
  CHECK(odometry[0].state == mission::VehicleState::kLanded);
  world.end_tick(60, {from(2, to(odometry[0].pose.p, {0.5, 2, 2}, 6, 3))});
  run(world, 61, 100);
}

}  // namespace

TEST_CASE("every live robot gets its odometry each tick and its sensors at their rates") {
  World world = make_world(small_fleet());
  int scans = 0, sightings = 0, batteries = 0, odometries = 0, foreign = 0;
  std::uint64_t n = 0;
  for (std::uint64_t k = 0; k < 100; ++k) {
    const auto samples = world.begin_tick(k);
    REQUIRE(samples.size() == 3);
    for (const auto& s : samples) {
      for (const auto& m : s.messages) {
        const mission::Envelope e = dds::peek_envelope(m.cdr);
        CHECK(e.src == kWorldId);
        CHECK(e.n == ++n);
        odometries += m.cls == MessageClass::kOdometry;
        scans += m.cls == MessageClass::kScan;
        sightings += m.cls == MessageClass::kSightings;
        batteries += m.cls == MessageClass::kBattery;
        foreign += m.cls == MessageClass::kSightings && s.robot != RobotId{1};
      }
    }
    world.end_tick(k, {});
  }
  CHECK(odometries == 300);
  CHECK(scans == 60);
  CHECK(sightings == 5);
  CHECK(batteries == 30);
  CHECK(foreign == 0);
}

TEST_CASE("a vehicle follows the trajectory its process sent") {
  World world = make_world(small_fleet());
  world.begin_tick(0);
  world.end_tick(0, {from(1, to({0, 0, 2}, {0, -3, 2}, 0, 4))});
  run(world, 1, 60);
  world.begin_tick(60);
  CHECK((true_state(world.truth(), 1).pose.p - Vec3(0, -3, 2)).norm() < 1e-6);
}

TEST_CASE("an inspection answers at the tick its hold is over, and broken by motion it restarts") {
  World world = make_world(small_fleet());
  world.begin_tick(0);
  world.end_tick(0, {from(2, inspect(1, {3, 2, 2}))});
  auto answers = run<mission::Inspected>(world, 1, 31, 2, MessageClass::kInspected);
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].outcome == mission::InspectOutcome::kFound);
  CHECK(answers[0].time == SimTime::from_s(3));
  CHECK(world.progress().features_inspected == 1);

  world.begin_tick(31);
  world.end_tick(31, {from(2, inspect(2, {3, 2, 2}))});
  run(world, 32, 50);
  world.begin_tick(50);
  world.end_tick(50, {from(2, to({0.5, 2, 2}, {0.5, 1.2, 2}, 5, 1.5))});
  answers = run<mission::Inspected>(world, 51, 120, 2, MessageClass::kInspected);
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].time > SimTime::from_s(9));
  CHECK(world.summary()["areas"]["duplicate_inspected"] == 1);
}

TEST_CASE("only inspectors inspect") {
  World world = make_world(small_fleet());
  world.begin_tick(0);
  world.end_tick(0, {from(1, inspect(1, {3, 0, 2}))});
  CHECK(run<mission::Inspected>(world, 1, 100, 1, MessageClass::kInspected).empty());
  CHECK(world.summary()["rule_violations"] == 1);
}

TEST_CASE("a dead process's robot stops, lands and blocks rays") {
  World world = make_world(small_fleet());
  run(world, 0, 10);
  world.begin_tick(10);
  world.set_alive(RobotId{2}, false);
  world.end_tick(10, {from(2, to({0.5, 2, 2}, {0.5, 8, 2}, 1, 4))});
  run(world, 11, 80);
  CHECK(world.begin_tick(80).size() == 2);
  const mission::TrueState dead = true_state(world.truth(), 2);
  CHECK(dead.state == mission::VehicleState::kDead);
  CHECK(dead.pose.p.z() < 0.3);
  const auto summary = world.summary();
  REQUIRE(summary["robots_lost"].size() == 1);
  CHECK(summary["robots_lost"][0]["robot"] == 2);
  CHECK(summary["robots_lost"][0]["t_s"] == 1.0);
  CHECK(summary["collisions"] == 0);

  // The explorer turns to it: the body on the ground shows in its scans.
  world.end_tick(80, {from(1, to({0, 0, 2}, {-2.5, 2, 0.5}, 8, 4))});
  int near = 0;
  for (const auto& scan : run<mission::Scan>(world, 81, 140, 1, MessageClass::kScan)) {
    if (scan.time < SimTime::from_s(13)) continue;
    const std::uint32_t row = 12;
    for (std::uint32_t c = 20; c < 28; ++c) {
      const std::uint16_t mm = scan.range_mm[row * scan.columns + c];
      near += mm != 0 && mm < 3000;
    }
  }
  CHECK(near > 0);
}

TEST_CASE("a revived process finds its robot landed and may fly it again") {
  World world = make_world(small_fleet());
  world.set_alive(RobotId{2}, false);
  run(world, 0, 60);
  world.set_alive(RobotId{2}, true);
  find_landed_and_fly(world);
  world.begin_tick(100);
  CHECK(true_state(world.truth(), 2).pose.p.z() == Approx(2).margin(1e-6));
}

TEST_CASE("a collision is counted once and told in the events") {
  World world = make_world(small_fleet());
  world.begin_tick(0);
  world.end_tick(0, {from(1, to({0, 0, 2}, {2.9, 0, 2}, 0, 4))});
  run(world, 1, 60);
  CHECK(world.progress().collisions == 1);
  int told = 0;
  for (const auto& e : world.take_events())
    told += e["event"] == "collision" && e["with"] == "site";
  CHECK(told == 1);
  CHECK(world.take_events().empty());
}

TEST_CASE("operator requests reach the station, scripted ones at their time") {
  mission::Mission m = small_fleet();
  m.script = {{SimTime::from_s(1), "abort", kNoRobot}, {SimTime::from_s(1), "kill", RobotId{2}}};
  World world = make_world(m);
  CHECK(world.scripted(9).empty());
  REQUIRE(world.scripted(10).size() == 1);
  CHECK(world.scripted(10)[0].robot == RobotId{2});
  CHECK(world.scripted(11).empty());
  world.operator_request(mission::RequestVerb::kHold, RobotId{1});
  const auto told = run<mission::OperatorRequest>(world, 0, 20, 0, MessageClass::kOperatorRequest);
  REQUIRE(told.size() == 2);
  CHECK(told[0].verb == mission::RequestVerb::kHold);
  CHECK(told[1].verb == mission::RequestVerb::kAbort);
  CHECK(told[1].envelope.sent == SimTime::from_s(1));
}

TEST_CASE("a paused process gets nothing, its vehicle lands, and later it may fly again") {
  mission::Mission m = small_fleet();
  m.script = {lasting(1, "pause", RobotId{2}, 5)};
  World world = make_world(m);
  CHECK(world.paused(9).empty());
  CHECK(world.paused(10) == std::set{RobotId{2}});
  CHECK(world.paused(60).empty());
  run(world, 0, 10);
  CHECK(world.begin_tick(10).size() == 2);
  world.end_tick(10, {});
  run(world, 11, 60);
  CHECK(true_state(world.truth(), 2).pose.p.z() < 0.3);
  find_landed_and_fly(world);
  CHECK(true_state(world.truth(), 2).pose.p.z() == Approx(2).margin(1e-6));
  CHECK(world.summary()["robots_lost"].empty());
}

TEST_CASE("a pause within the second of patience changes nothing of what is flown") {
  mission::Mission m = small_fleet();
  m.script = {lasting(1, "pause", RobotId{1}, 0.8)};
  World world = make_world(m);
  world.begin_tick(0);
  world.end_tick(0, {from(1, to({0, 0, 2}, {0, -3, 2}, 0, 4))});
  run(world, 1, 60);
  CHECK((true_state(world.truth(), 1).pose.p - Vec3(0, -3, 2)).norm() < 1e-6);
}

TEST_CASE("a blind camera scans, sights and inspects nothing, while it lasts") {
  mission::Mission m = small_fleet();
  m.script = {lasting(1, "blind", kNoRobot, 8)};
  World world = make_world(m);
  run(world, 0, 10);
  world.begin_tick(10);
  world.end_tick(10, {from(2, inspect(1, {3, 2, 2}))});
  int scans = 0, sightings = 0;
  std::vector<mission::Inspected> answers;
  for (std::uint64_t k = 11; k < 90; ++k) {
    const auto samples = world.begin_tick(k);
    scans += static_cast<int>(all_of<mission::Scan>(samples, 1, MessageClass::kScan).size());
    sightings +=
        static_cast<int>(all_of<mission::Sightings>(samples, 1, MessageClass::kSightings).size());
    for (auto& a : all_of<mission::Inspected>(samples, 2, MessageClass::kInspected))
      answers.push_back(std::move(a));
    world.end_tick(k, {});
  }
  CHECK(scans == 0);
  CHECK(sightings == 0);
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].outcome == mission::InspectOutcome::kRefusedView);
  CHECK(run<mission::Scan>(world, 90, 100, 1, MessageClass::kScan).size() == 2);
}

TEST_CASE("a drained battery is at the level the script says, and lands its robot at none") {
  mission::Mission m = small_fleet();
  mission::ScriptedEvent drain{SimTime::from_s(1), "drain", RobotId{1}};
  drain.value = 0.25;
  m.script = {drain, {SimTime::from_s(2), "drain", RobotId{2}}};
  World world = make_world(m);
  const auto told = run<mission::Battery>(world, 0, 60, 1, MessageClass::kBattery);
  CHECK(told.front().charge == 1);
  CHECK(told.back().charge == 0.25f);
  CHECK(true_state(world.truth(), 1).pose.p.z() == 2);
  CHECK(true_state(world.truth(), 2).pose.p.z() < 0.3);
}

TEST_CASE("an empty battery lands its robot") {
  mission::Mission m = small_fleet();
  m.fleet[1].vehicle.capacity_mah = 10;
  m.fleet[1].vehicle.discharge_mah_per_s = 5;
  World world = make_world(m);
  run(world, 0, 80);
  world.begin_tick(80);
  CHECK(true_state(world.truth(), 1).state == mission::VehicleState::kLanded);
}

TEST_CASE("a command that cannot be read is counted and changes nothing") {
  World world = make_world(small_fleet());
  mission::Message m = from(1, to({0, 0, 2}, {0, -3, 2}, 0, 4));
  m.cdr.resize(m.cdr.size() - 20);
  world.begin_tick(0);
  world.end_tick(0, {m, from(77, to({0, 0, 2}, {0, -3, 2}, 0, 4))});
  run(world, 1, 30);
  CHECK(world.summary()["rule_violations"] == 2);
  CHECK(true_state(world.truth(), 1).pose.p == Vec3(0, 0, 2));
}

TEST_CASE("the mission is complete when it is declared and everything is delivered") {
  World world = make_world(small_fleet());
  world.begin_tick(0);
  world.end_tick(0, {from(2, inspect(1, {3, 2, 2}))});
  const auto answers = run<mission::Inspected>(world, 1, 40, 2, MessageClass::kInspected);
  REQUIRE(answers.size() == 1);
  mission::Inspection body;
  body.found = true;
  body.findings = answers[0].found;
  body.payload = answers[0].payload;
  store::RecordHeader h;
  h.author = {RobotId{2}, 1};
  h.cls = store::RecordClass::kInspection;
  world.station_received(dds::encode_record(h, body), MessageClass::kInspection);
  CHECK(world.progress().features_delivered == 1);
  world.station_declares_complete();
  const auto summary = world.summary();
  CHECK(summary["finish_rate"] == 0.5);
  CHECK(summary["complete"] == false);
  CHECK(summary["finish_time_s"] == 4.0);
  CHECK(summary["delivered_time_s"].is_null());
  CHECK(summary["home_time_s"].is_null());
  CHECK(world.features_csv().find("0,0,3.000,2.000,2.000") != std::string::npos);
}

TEST_CASE("home is when everybody has landed at their start after the declaration") {
  World world = make_world(small_fleet());
  world.station_declares_complete();
  run(world, 0, 5);
  CHECK_FALSE(world.progress().all_landed);
  world.begin_tick(5);
  mission::Trajectory land;
  land.land = true;
  world.end_tick(5, {from(1, land), from(2, land)});
  run(world, 6, 80);
  CHECK(world.progress().all_landed);
  CHECK(world.summary()["home_time_s"].is_number());
}

TEST_CASE("a rover that turns on its way home has not arrived") {
  World world = make_world(small_fleet());
  world.station_declares_complete();
  world.begin_tick(0);
  mission::Trajectory land;
  land.land = true;
  world.end_tick(0, {from(0, to({-6, 0, 0.4}, {-6, 4, 0.4}, 0, 5)), from(1, land), from(2, land)});
  run(world, 1, 100);
  CHECK_FALSE(world.progress().all_landed);  // stands, four metres off
  run(world, 101, 300);
  CHECK(world.progress().all_landed);  // it stays there
  CHECK(world.summary()["home_time_s"].is_null());
}

TEST_CASE("equal seeds give equal bytes, different seeds do not") {
  const auto record = [](std::uint64_t seed) {
    mission::Mission m = small_fleet();
    m.seed = seed;
    World world = make_world(m);
    std::vector<Bytes> all;
    for (std::uint64_t k = 0; k < 60; ++k) {
      for (const auto& s : world.begin_tick(k)) {
        for (const auto& msg : s.messages) all.push_back(msg.cdr);
      }
      const std::uint64_t trace = world.trace();
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&trace);
      all.emplace_back(bytes, bytes + sizeof trace);
      std::vector<mission::Message> commands;
      if (k == 3) commands.push_back(from(1, to({0, 0, 2}, {0, -3, 2}, 0.3, 4)));
      if (k == 5) commands.push_back(from(2, inspect(1, {3, 2, 2})));
      world.end_tick(k, commands);
    }
    return all;
  };
  CHECK(record(1) == record(1));
  CHECK(record(1) != record(2));
}

TEST_CASE("a mission that does not fit the scene is bad input, in one line that says why") {
  const auto message = [](const mission::Mission& m, Mesh mesh = walled()) -> std::string {
    try {
      World(m, scene_of(std::move(mesh)), {}, {});
    } catch (const BadInput& e) {
      return e.what();
    }
    return "";
  };
  mission::Mission m = small_fleet();
  CHECK(message(m).empty());

  m.boxes.push_back(Box::from_corners({100, 0, 0}, {110, 10, 5}));
  CHECK(message(m).find("test.yaml: boxes[1]: lies outside the scene") == 0);

  m = small_fleet();
  m.fleet[1].start.p = {2.9, 0, 2};
  CHECK(message(m).find("robot 1 at (2.90, 0.00, 2.00) starts 0.10 m from a surface") !=
        std::string::npos);

  m = small_fleet();
  m.fleet[2].start.p = {0.3, 0, 2};
  CHECK(message(m).find("overlaps robot 2: 0.30 m apart") != std::string::npos);

  m = small_fleet();
  m.fleet[1].start.p = {-6, 5, 1.5};
  Mesh solid = ground();
  add_solid(solid, {-8, 3, 0}, {-4, 7, 3});
  CHECK(message(m, solid).find("robot 1 at (-6.00, 5.00, 1.50) starts inside a wall") !=
        std::string::npos);

  m = small_fleet();
  m.fleet[0].start.p = {-30, 0, 0.4};
  CHECK(message(m).find("has no ground below") != std::string::npos);
}
