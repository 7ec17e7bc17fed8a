#include "commsim/world/vehicle_model.h"

#include <algorithm>
#include <cmath>

namespace muster::world {
namespace {

constexpr Duration kSilence{1'000'000};  // RULES: a silent process's vehicle stops after 1 s
constexpr double kDescentMps = 0.8;
constexpr double kCreepMps = 0.1;     // the last centimetres of a landing
constexpr double kTouchM = 0.01;      // gap at which the body stands on the ground
constexpr double kSpeedSlack = 1.02;  // a Hermite spline swings a little above its states' speed
constexpr double kAccelSlack = 1.05;
constexpr double kLandSpeedMps = 0.2;  // slow enough to start the descent
constexpr Duration kLandPatience{3'000'000};
constexpr double kLookM = 0.75;    // how far beside the body a landing looks for what it may touch
constexpr double kTakeOffM = 0.3;  // above the touch-down spot it counts as flying again

Vec3 clamped(const Vec3& v, double limit) {
  const double n = v.norm();
  return n > limit ? Vec3(v * (limit / n)) : v;
}

/// To a tenth of a millimetre, finer than a ray in single precision tells on every processor: level
/// ground is level.
double ground_below(const Vec3& p, const Hit& hit) {
  return std::round((p.z() - hit.distance_m) * 1e4) * 1e-4;
}

}  // namespace

Reference sample(const std::vector<mission::TimedState>& states, SimTime t) {
  if (t <= states.front().t) {
    const auto& s = states.front();
    const bool only = states.size() == 1;
    return {s.p, only || t < s.t ? Vec3(Vec3::Zero()) : s.v_mps, s.yaw_rad, only && t >= s.t};
  }
  if (t >= states.back().t) return {states.back().p, Vec3::Zero(), states.back().yaw_rad, true};
  const auto after =
      std::upper_bound(states.begin(), states.end(), t,
                       [](SimTime at, const mission::TimedState& s) { return at < s.t; });
  const mission::TimedState &b = *after, &a = *(after - 1);
  const double h = (b.t - a.t).s(), u = (t - a.t).s() / h;
  const double u2 = u * u, u3 = u2 * u;
  Reference r;
  r.p = (2 * u3 - 3 * u2 + 1) * a.p + (u3 - 2 * u2 + u) * h * a.v_mps + (3 * u2 - 2 * u3) * b.p +
        (u3 - u2) * h * b.v_mps;
  r.v_mps = (6 * u2 - 6 * u) / h * (a.p - b.p) + (3 * u2 - 4 * u + 1) * a.v_mps +
            (3 * u2 - 2 * u) * b.v_mps;
  r.yaw_rad = wrap_angle(a.yaw_rad + u * wrap_angle(b.yaw_rad - a.yaw_rad));
  return r;
}

VehicleModel::VehicleModel(const mission::RobotConfig& config, const Scene& scene)
    : vehicle_(config.vehicle), scene_(scene), pose_(config.start) {
  touch_down_z_ = pose_.p.z();
  if (!vehicle_.ground) return;
  airborne_ = false;
  const auto hit = scene_.cast(pose_.p, -Vec3::UnitZ(), vehicle_.ride_height_m + 2);
  ground_z_ = hit ? ground_below(pose_.p, *hit) : pose_.p.z() - vehicle_.ride_height_m;
  pose_.p.z() = ground_z_ + vehicle_.ride_height_m;
}

bool VehicleModel::command(const mission::Trajectory& trajectory) {
  if (!alive_ || !powered_) return false;
  for (std::size_t i = 1; i < trajectory.states.size(); ++i) {
    if (trajectory.states[i].t <= trajectory.states[i - 1].t) return false;
  }
  const bool down = phase_ == Phase::kDown;
  if (down && trajectory.states.empty()) return true;  // told to stop, and it does stand
  if (phase_ == Phase::kDown) touch_down_z_ = pose_.p.z();
  states_ = trajectory.states;
  land_ = trajectory.land;
  phase_ = states_.empty() ? Phase::kHold : Phase::kFollow;
  return true;
}

void VehicleModel::set_alive(bool alive, SimTime now) {
  if (alive == alive_) return;
  alive_ = alive;
  silent_since_ = now;
  if (!alive) return;
  // A revived process finds a vehicle that holds still and waits for its first trajectory.
  states_.clear();
  land_ = false;
  if (phase_ != Phase::kDown) phase_ = Phase::kHold;
}

void VehicleModel::set_paused(bool paused, SimTime now) {
  if (paused || now - silent_since_ >= kSilence) return set_alive(!paused, now);
  alive_ = true;
}

bool VehicleModel::abandoned(SimTime now) const {
  return !powered_ || (!alive_ && now - silent_since_ >= kSilence);
}

mission::VehicleState VehicleModel::state() const {
  using mission::VehicleState;
  if (phase_ == Phase::kDown) return alive_ ? VehicleState::kLanded : VehicleState::kDead;
  if (phase_ == Phase::kDescend) return VehicleState::kLanding;
  return phase_ == Phase::kFollow || velocity_.norm() > 0.01 ? VehicleState::kMoving
                                                             : VehicleState::kReady;
}

void VehicleModel::step(SimTime from, Duration dt) {
  if (phase_ == Phase::kDown) return;
  exact_ = false;
  if (abandoned(from) && phase_ == Phase::kFollow) {
    states_.clear();
    phase_ = Phase::kHold;
  }
  if (abandoned(from)) land_ = true;
  switch (phase_) {
    case Phase::kFollow:
      follow(from, dt);
      break;
    case Phase::kHold:
      brake(dt);
      if (land_ && velocity_.norm() < 1e-9) phase_ = Phase::kDescend;
      break;
    case Phase::kDescend:
      descend(dt);
      break;
    case Phase::kDown:
      break;
  }
  if (!exact_) reported_velocity_ = velocity_;
  if (!vehicle_.ground && !airborne_ && phase_ != Phase::kDown && phase_ != Phase::kDescend) {
    airborne_ = pose_.p.z() > touch_down_z_ + kTakeOffM;
  }
}

void VehicleModel::follow(SimTime from, Duration dt) {
  const Reference target = sample(states_, from + dt);
  track(target, dt);
  if (!target.finished) return;
  Vec3 error = target.p - pose_.p;
  if (vehicle_.ground) error.z() = 0;
  const bool there = error.norm() < 0.02 && velocity_.norm() < 0.01 &&
                     std::abs(wrap_angle(target.yaw_rad - pose_.yaw_rad)) < 1e-3;
  if (!land_) {
    if (there) {
      phase_ = Phase::kHold;
      states_.clear();
    }
    return;
  }
  const bool late = from - states_.back().t > kLandPatience && velocity_.norm() < kLandSpeedMps;
  if (there || late) phase_ = Phase::kHold, states_.clear();
}

void VehicleModel::track(const Reference& target, Duration dt) {
  const double h = dt.s();
  Vec3 error = target.p - pose_.p;
  if (vehicle_.ground) error.z() = 0;
  const Vec3 exact = error / h;
  const double accel = vehicle_.accel_mps2;
  if (exact.norm() <= vehicle_.speed_mps * kSpeedSlack &&
      (exact - velocity_).norm() <= accel * kAccelSlack * h) {
    velocity_ = exact;
    reported_velocity_ = target.v_mps;
    exact_ = !vehicle_.ground;
  } else {
    // Behind: head for the target with the target's speed plus what can still be braked away over
    // the distance left.
    const double distance = error.norm();
    const double closing = std::min(std::sqrt(1.4 * accel * distance), distance / (4 * h));
    Vec3 wanted = target.v_mps;
    if (vehicle_.ground) wanted.z() = 0;
    if (distance > 1e-9) wanted += error / distance * closing;
    wanted = clamped(wanted, vehicle_.speed_mps);
    velocity_ += clamped(wanted - velocity_, accel * h);
  }
  turn(target.yaw_rad, dt);
  move(dt);
}

void VehicleModel::turn(double yaw_rad, Duration dt) {
  const double error = wrap_angle(yaw_rad - pose_.yaw_rad);
  const double limit = vehicle_.yaw_rate_radps;
  yaw_rate_ = std::clamp(error / dt.s(), -limit, limit);
  pose_.yaw_rad = wrap_angle(pose_.yaw_rad + yaw_rate_ * dt.s());
}

void VehicleModel::brake(Duration dt) {
  yaw_rate_ = 0;
  if (velocity_.isZero(0)) return;
  velocity_ -= clamped(velocity_, vehicle_.accel_mps2 * dt.s());
  move(dt);
}

void VehicleModel::move(Duration dt) {
  if (vehicle_.ground) return move_on_ground(dt);
  pose_.p += velocity_ * dt.s();
}

void VehicleModel::move_on_ground(Duration dt) {
  velocity_.z() = 0;
  if (velocity_.isZero(0)) return;
  const Vec3 next = pose_.p + velocity_ * dt.s();
  const auto hit = scene_.cast(next, -Vec3::UnitZ(), vehicle_.ride_height_m + vehicle_.max_step_m);
  const double ground = hit ? ground_below(next, *hit) : 0;
  if (!hit || std::abs(ground - ground_z_) > vehicle_.max_step_m) {
    velocity_.setZero();  // a ledge or a drop: it stays where it is
    return;
  }
  ground_z_ = ground;
  pose_.p = next;
  pose_.p.z() = ground + vehicle_.ride_height_m;
}

void VehicleModel::descend(Duration dt) {
  if (vehicle_.ground) return touch_down();
  airborne_ = false;
  const double h = dt.s();
  // Nothing below (a scene without ground): its lowest point serves.
  const double floor = scene_.low().z();
  const auto hit = scene_.cast(pose_.p, -Vec3::UnitZ(), std::max(1.0, pose_.p.z() - floor + 1));
  const double below = hit ? hit->distance_m : pose_.p.z() - floor;
  // On a slope or an edge the sphere touches beside the point straight below.
  const double gap =
      std::min(below, scene_.clearance(pose_.p, vehicle_.radius_m + kLookM)) - vehicle_.radius_m;
  if (gap <= kTouchM || below - vehicle_.radius_m <= kTouchM) return touch_down();
  const double room = gap - kTouchM / 2;
  double speed = std::min(kDescentMps, std::sqrt(vehicle_.accel_mps2 * room));
  speed =
      std::clamp(speed, kCreepMps, std::max(kCreepMps, -velocity_.z() + vehicle_.accel_mps2 * h));
  velocity_ = Vec3(0, 0, -std::min(speed, std::max(room / h, 1e-6)));
  yaw_rate_ = 0;
  move(dt);
}

void VehicleModel::touch_down() {
  velocity_.setZero();
  yaw_rate_ = 0;
  phase_ = Phase::kDown;
  touch_down_z_ = pose_.p.z();
  states_.clear();
  land_ = false;
}

}  // namespace muster::world
