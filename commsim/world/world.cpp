#include "commsim/world/world.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/hash.h"
#include "common/dds/convert.h"
#include "commsim/world/observable.h"
#include "commsim/world/reachable.h"
#include "commsim/world/site_check.h"
#include "commsim/world/world_impl.h"

namespace muster::world {
namespace {

constexpr Duration kSubStep{20'000};
constexpr int kSubSteps = static_cast<int>(kTick.us / kSubStep.us);
constexpr double kBatteryRateHz = 1;

std::vector<Feature> all_spots(const FeatureSet& set) {
  std::vector<Feature> spots = set.features;
  spots.insert(spots.end(), set.decoys.begin(), set.decoys.end());
  return spots;
}

std::optional<mission::RequestVerb> verb_from(const std::string& name) {
  using mission::RequestVerb;
  if (name == "hold") return RequestVerb::kHold;
  if (name == "resume") return RequestVerb::kResume;
  if (name == "return") return RequestVerb::kReturn;
  if (name == "land") return RequestVerb::kLand;
  if (name == "abort") return RequestVerb::kAbort;
  return std::nullopt;
}

}  // namespace

World::Impl::Robot::Robot(const mission::RobotConfig& c, const mission::Mission& m,
                          const Scene& scene, const std::vector<Feature>& features)
    : config(c),
      vehicle(c, scene),
      camera(RangeSensor::depth_camera(c.vehicle)),
      lidar(RangeSensor::lidar(c.vehicle)),
      inspector(c, m, features),
      scan_noise(m.seed, c.id, "depth camera"),
      lidar_noise(m.seed, c.id, "lidar"),
      sighting_noise(m.seed, c.id, "sightings") {}

World::Impl::Impl(const mission::Mission& m, std::shared_ptr<const Scene> s, FeatureSet f,
                  const std::vector<Vec3>& surface)
    : mission(m),
      scene(std::move(s)),
      features(std::move(f)),
      spots(all_spots(features)),
      around(*scene, {}),
      energy(mission),
      contacts(*scene),
      ledger(features.features),
      coverage(mission, surface),
      activity(mission) {
  std::vector<mission::RobotConfig> fleet = mission.fleet;
  std::sort(fleet.begin(), fleet.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  for (const mission::RobotConfig& c : fleet) {
    robots.emplace_back(c, mission, *scene, features.features);
    around.bodies().push_back({c.id, c.start.p, c.vehicle.radius_m});
  }
  refresh_bodies();
}

World::World(const mission::Mission& mission, std::shared_ptr<const Scene> scene) {
  check_site(mission, *scene);
  const ReachableSpace reachable(*scene, mission);
  FeatureSet features = draw_features(*scene, mission, reachable);
  std::vector<Vec3> surface;
  for (const Voxel& v : observable_surface(*scene, mission, reachable)) {
    surface.push_back(Vec3(v.x + 0.5, v.y + 0.5, v.z + 0.5) * mission.resolution_m);
  }
  impl_ = std::make_unique<Impl>(mission, std::move(scene), std::move(features), surface);
}

World::World(const mission::Mission& mission, std::shared_ptr<const Scene> scene,
             FeatureSet features, const std::vector<Vec3>& surface) {
  check_site(mission, *scene);
  impl_ = std::make_unique<Impl>(mission, std::move(scene), std::move(features), surface);
}
World::~World() = default;

// ---- a tick's samples

World::Impl::Robot* World::Impl::find(RobotId id) {
  const auto it = std::find_if(robots.begin(), robots.end(),
                               [id](const Robot& r) { return r.config.id == id; });
  return it == robots.end() ? nullptr : &*it;
}

void World::Impl::refresh_bodies() {
  for (std::size_t i = 0; i < robots.size(); ++i) {
    around.bodies()[i].p = robots[i].vehicle.pose().p;
  }
}

bool World::Impl::due(const Robot& robot, double rate_hz) const {
  if (rate_hz <= 0) return false;
  const auto period = std::max<std::uint64_t>(
      1, static_cast<std::uint64_t>(std::llround(1 / (rate_hz * kTick.s()))));
  return (tick + robot.config.id.value) % period == 0;  // staggered, so that ticks cost alike
}

template <class T>
void World::Impl::send(Samples& out, T message) {
  message.envelope.n = ++sent;
  message.envelope.src = kWorldId;
  message.envelope.sent = now;
  out.messages.push_back(dds::encode(message));
}

std::vector<World::Samples> World::begin_tick(std::uint64_t k) {
  Impl& w = *impl_;
  w.tick = k;
  w.now = time_of_tick(k);
  for (const mission::ScriptedEvent& e : w.mission.script) {
    const auto verb = verb_from(e.verb);
    if (verb && e.due_at(k)) operator_request(*verb, e.robot);
  }
  w.run_script();
  std::vector<Samples> samples;
  for (std::size_t i = 0; i < w.robots.size(); ++i) {
    if (!w.robots[i].alive || w.robots[i].paused) continue;
    samples.push_back({w.robots[i].config.id, {}});
    w.sample(w.robots[i], i, samples.back());
  }
  return samples;
}

bool World::Impl::scripted(const char* verb, const Robot& robot) const {
  return mission::in_force(mission.script, verb, robot.config.id, now);
}

/// What the script does to vehicles: batteries drained, processes that fall silent and speak again.
void World::Impl::run_script() {
  for (const mission::ScriptedEvent& e : mission.script) {
    if (e.verb != "drain" || !e.due_at(tick)) continue;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      if (e.concerns(robots[i].config.id)) energy.set_charge(i, e.value);
    }
  }
  for (Robot& r : robots) {
    const bool paused = scripted("pause", r);
    if (paused == r.paused) continue;
    r.paused = paused;
    if (r.alive) r.vehicle.set_paused(paused, now);
    event(paused ? "paused" : "resumed", {{"robot", r.config.id.value}}, now);
  }
}

void World::Impl::sample(Robot& robot, std::size_t index, Samples& out) {
  mission::Odometry odometry;
  odometry.time = now;
  odometry.pose = robot.vehicle.pose();
  odometry.velocity_mps = robot.vehicle.velocity_mps();
  odometry.yaw_rate_radps = robot.vehicle.yaw_rate_radps();
  odometry.state = robot.vehicle.state();
  send(out, odometry);
  if (due(robot, robot.config.vehicle.scan_rate_hz)) sample_scans(robot, index, out);
  if (robot.config.role == mission::Role::kExplorer &&
      due(robot, mission.sensing.sighting_rate_hz) && !scripted("blind", robot)) {
    sample_sightings(robot, out);
  }
  if (due(robot, kBatteryRateHz)) {
    const Energy::Battery& b = energy.battery(index);
    mission::Battery battery;
    battery.time = now;
    battery.charge = static_cast<float>(b.charge);
    battery.capacity_mah = static_cast<float>(robot.config.vehicle.capacity_mah);
    battery.charging = b.charging;
    battery.station = b.station;
    send(out, battery);
  }
  for (mission::Inspected& result : robot.results) send(out, std::move(result));
  robot.results.clear();
  sample_requests(robot, out);
}

void World::Impl::sample_scans(Robot& robot, std::size_t index, Samples& out) {
  const RobotId id = robot.config.id;
  const Pose& pose = robot.vehicle.pose();
  if (robot.camera.fitted() && !scripted("blind", robot)) {
    const bool counts = robot.config.role == mission::Role::kExplorer && !declared;
    mission::Scan scan = robot.camera.sweep(around, id, pose, mission.sensing, robot.scan_noise,
                                            counts ? &robot.ray_ends : nullptr);
    scan.time = now;
    if (counts) activity.saw(index, pose.p, robot.ray_ends, scan.columns);
    send(out, std::move(scan));
  }
  if (robot.lidar.fitted()) {
    mission::Scan scan = robot.lidar.sweep(around, id, pose, mission.sensing, robot.lidar_noise);
    scan.time = now;
    send(out, std::move(scan));
  }
}

void World::Impl::sample_sightings(Robot& robot, Samples& out) {
  const RobotId id = robot.config.id;
  Look seen = look_for_spots(around, id, robot.vehicle.pose(), robot.config.vehicle, spots,
                             mission.sensing, robot.sighting_noise);
  for (const std::size_t i : seen.reported) {
    if (!spots[i].real || !ledger.sighted(spots[i].id, id, now)) continue;
    event("sighted", {{"feature", spots[i].id.value}, {"robot", id.value}}, now);
  }
  seen.sightings.time = now;
  send(out, std::move(seen.sightings));
}

void World::Impl::sample_requests(Robot& robot, Samples& out) {
  if (requests.empty() || robot.config.id != mission.station()) return;
  for (const mission::OperatorRequest& r : requests) send(out, r);
  requests.clear();
}

mission::Truth World::truth() const {
  mission::Truth truth;
  truth.envelope.src = kWorldId;
  truth.envelope.sent = impl_->now;
  truth.k = impl_->tick;
  truth.time = impl_->now;
  for (const Impl::Robot& r : impl_->robots) {
    truth.robots.push_back(
        {r.config.id, r.vehicle.state(), r.vehicle.pose(), r.vehicle.velocity_mps()});
  }
  return truth;
}

std::uint64_t World::trace() const {
  Hasher hasher;
  hasher.add(impl_->tick);
  for (const Impl::Robot& r : impl_->robots) {
    const Pose& pose = r.vehicle.pose();
    hasher.add(r.config.id.value).add(r.vehicle.state()).add(pose.yaw_rad);
    for (int a = 0; a < 3; ++a) hasher.add(pose.p[a]).add(r.vehicle.velocity_mps()[a]);
  }
  return hasher.value();
}

// ---- a tick's motion

void World::end_tick(std::uint64_t k, const std::vector<mission::Message>& commands) {
  Impl& w = *impl_;
  w.tick = k;
  w.now = time_of_tick(k);
  for (const mission::Message& m : commands) w.execute(m);
  for (Impl::Robot& r : w.robots) r.fastest_mps = 0;
  for (int i = 0; i < kSubSteps; ++i) w.substep(w.now + kSubStep * i);
  w.refresh_bodies();
  // What is asked from here on, until the next tick begins, is about the instant the motion has led
  // to.
  w.tick = k + 1;
  w.now = time_of_tick(w.tick);
  for (Impl::Robot& r : w.robots) w.look(r, w.now);
  w.account();
}

void World::Impl::execute(const mission::Message& message) {
  try {
    Robot* robot = find(dds::peek_envelope(message.cdr).src);
    if (!robot) return violation("a command from a robot that is not in the fleet");
    if (robot->alive) execute_on(*robot, message);
  } catch (const BadInput& e) {
    violation(std::string("a command that cannot be read: ") + e.what());
  }
}

void World::Impl::execute_on(Robot& robot, const mission::Message& message) {
  const std::string who = "robot " + std::to_string(robot.config.id.value);
  switch (message.cls) {
    case mission::MessageClass::kTrajectory:
      if (!robot.vehicle.command(dds::decode<mission::Trajectory>(message))) {
        event("trajectory_refused", {{"robot", robot.config.id.value}}, now);
      }
      return;
    case mission::MessageClass::kInspect: {
      const auto inspect = dds::decode<mission::Inspect>(message);
      if (robot.config.role != mission::Role::kInspector) {
        return violation(who + " asks to inspect and is no inspector");
      }
      for (auto& answer : robot.inspector.request(inspect, now)) {
        robot.results.push_back(std::move(answer.message));
      }
      look(robot, now);
      return;
    }
    case mission::MessageClass::kCharge:
      energy.ask(static_cast<std::size_t>(&robot - robots.data()),
                 dds::decode<mission::Charge>(message).station);
      return;
    default:
      violation(who + " sends the world a " + mission::topic_name(message.cls));
  }
}

void World::Impl::substep(SimTime from) {
  std::vector<Energy::Use> uses;
  for (const Robot& r : robots) uses.push_back({r.vehicle.pose().p, r.vehicle.resting()});
  energy.step(uses, kSubStep);
  for (std::size_t i = 0; i < robots.size(); ++i) {
    Robot& r = robots[i];
    const bool rested = r.vehicle.resting();
    r.vehicle.set_powered(energy.battery(i).charge > 0);
    const Vec3 before = r.vehicle.pose().p;
    r.vehicle.step(from, kSubStep);
    r.way_m += (r.vehicle.pose().p - before).norm();
    r.fastest_mps = std::max(r.fastest_mps, r.vehicle.velocity_mps().norm());
    if (!rested && r.vehicle.resting())
      event("landed", {{"robot", r.config.id.value}}, from + kSubStep);
  }
  check_contacts();
}

void World::Impl::check_contacts() {
  std::vector<MovingBody> bodies;
  bodies.reserve(robots.size());
  for (const Robot& r : robots) {
    const mission::Vehicle& v = r.config.vehicle;
    MovingBody body{r.config.id,         r.vehicle.pose().p, v.radius_m,
                    r.vehicle.resting(), r.vehicle.flying(), std::nullopt};
    if (v.ground) body.footing_z = r.vehicle.ground_z() + v.max_step_m;
    bodies.push_back(body);
  }
  for (const Contact& c : contacts.step(bodies)) {
    ++collisions;
    nlohmann::json details = {
        {"robot", c.robot.value},
        {"p", {c.p.x(), c.p.y(), c.p.z()}},
        {"with", c.other == kNoRobot ? nlohmann::json("site") : nlohmann::json(c.other.value)}};
    event("collision", std::move(details), now);
  }
}

void World::Impl::look(Robot& robot, SimTime at) {
  if (!robot.inspector.busy()) return;
  // Blind is as good as too fast: nothing is in view.
  const double speed_mps =
      scripted("blind", robot) ? std::numeric_limits<double>::infinity() : robot.fastest_mps;
  for (auto& answer : robot.inspector.look(around, robot.vehicle.pose(), speed_mps, at)) {
    record_answer(robot.config.id, answer);
    robot.results.push_back(std::move(answer.message));
  }
}

// ---- from outside

void World::set_alive(RobotId id, bool alive) {
  Impl::Robot* robot = impl_->find(id);
  if (!robot || robot->alive == alive) return;
  robot->alive = alive;
  robot->vehicle.set_alive(alive && !robot->paused, impl_->now);
  impl_->event(alive ? "revived" : "dead", {{"robot", id.value}}, impl_->now);
  if (!alive) {
    robot->inspector.drop();
    robot->results.clear();
    impl_->lost.push_back({.robot = id, .at = impl_->now, .revived = {}});
    return;
  }
  for (Impl::Lost& l : impl_->lost) {
    if (l.robot == id && !l.revived) impl_->come_back(l);
  }
}

void World::operator_request(mission::RequestVerb verb, RobotId robot) {
  mission::OperatorRequest request;
  request.verb = verb;
  request.robot = robot;
  impl_->requests.push_back(request);
  if (robot == kNoRobot) impl_->called_home = verb >= mission::RequestVerb::kReturn;
}

std::vector<mission::ScriptedEvent> World::scripted(std::uint64_t k) const {
  std::vector<mission::ScriptedEvent> due;
  for (const mission::ScriptedEvent& e : impl_->mission.script) {
    if ((e.verb == "kill" || e.verb == "revive") && e.due_at(k)) due.push_back(e);
  }
  return due;
}

std::set<RobotId> World::paused(std::uint64_t k) const {
  std::set<RobotId> out;
  for (const Impl::Robot& r : impl_->robots) {
    const RobotId id = r.config.id;
    if (mission::in_force(impl_->mission.script, "pause", id, time_of_tick(k))) out.insert(id);
  }
  return out;
}

}  // namespace muster::world
