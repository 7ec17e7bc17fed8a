#include "common/robot/executive.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/log.h"
#include "common/nav/headway.h"

namespace muster::robot {
namespace {

constexpr double kRecheck_s = 0.2;
constexpr double kRetry_s = 0.5;
constexpr double kNoWay_s =
    2.0;  // a search that failed costs most, and the map seldom changes the answer at once:
constexpr double kNoWayLongest_s = 10;  // each failure doubles the wait, up to this
constexpr double kRise_m = 6;           // from the ground to where there is room
constexpr double kWayOut_m = 1.0;
constexpr int kPressed = 8;           // ways refused because of what touches the body already
constexpr double kTrailStep_m = 0.1;  // between places where it has been
constexpr std::size_t kTrail = 500;   // places
constexpr double kBackOut_m = 0.3;    // at least
constexpr double kOwnImage_m = 0.35;  // beyond the body: the noise of who mapped it, and a voxel
// What is planned keeps more distance from teammates than what is flown on: no braking for a
// centimetre.
constexpr double kPlanMargin_m = 0.4, kFlyMargin_m = 0.25;
constexpr double kMapClearance_m = 0.1;             // what the search keeps from bodies, too
constexpr double kCorners_m[] = {0.25, 0.1, 0.02};  // rounding; less where it touches the map
constexpr double kMakeRoomAfter_s = 2.0, kMakeRoomWithin_m = 3.0, kMakeRoomPause_s = 6.0;
constexpr double kTransitReplan_s = 0.7;  // a little more than one scan period
constexpr double kStepAsideAfter_s = 3.0;
// Somebody is to be met: the way ends this far from the place, within sight of it. It may stand
// there silent, and below and above the camera does not look.
constexpr double kBeforeSomebody_m = 1.4;
constexpr double kNextToGoal_m = 0.7;  // at the end of the way, this near: as near as it gets
constexpr double kNeighbour_m = 0.9;   // what is nearer to a teammate's start is the teammate's
constexpr int kLandingTries = 8;  // then it lands where it is, rather than hover until it falls
constexpr double kMoverMemory_s = 2.0;
// Behind somebody who may brake at any time: its word takes a tick, our answer another one.
constexpr Duration kReaction{300'000};
constexpr double kHeadway_m = 0.1;  // what is left between us when both have braked
constexpr double kFollows_m = 4.0, kMoves_mps = 0.3;
constexpr Duration kLeftAlone{1'000'000};  // a vehicle stops when its process is silent so long
constexpr Duration kForesight{2'500'000};
constexpr double kAnnounceStep_s = 0.5, kAnnounceSpan_s = 6.0;
constexpr double kSilentFrom_s = 1, kSilentUntil_s = 60, kSilentNear_m = 2.5;
constexpr double kWellHeard = 0.6;  // of the range
constexpr double kWaitForRadio_s = 60;
constexpr double kUnheard_s = 2.5;    // eight beacons in a row: a fifth of them is lost at times
constexpr double kRadioWorks_s = 60;  // since somebody was heard
constexpr double kSettled_m = 0.12, kSettled_rad = 0.08;

bool same_goal(const Intent& a, const Intent& b) {
  return a.kind == b.kind && a.use_yaw == b.use_yaw && a.through_unknown == b.through_unknown &&
         (a.goal.p - b.goal.p).norm() < 0.02 &&
         (!a.use_yaw || std::abs(wrap_angle(a.goal.yaw_rad - b.goal.yaw_rad)) < 0.02) &&
         a.area == b.area;
}

bool to_meet(const Intent& intent) {
  return intent.kind == Intent::Kind::kGo && intent.with != kNoRobot && !intent.use_yaw;
}

/// Of a path, seen from above.
double level_distance_m(const nav::Path& path, const Vec3& p) {
  double nearest_m = (path.points.front() - p).head<2>().norm();
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    const Eigen::Vector2d a = path.points[i - 1].head<2>(), leg = path.points[i].head<2>() - a;
    const double along = leg.squaredNorm() > 0 ? (p.head<2>() - a).dot(leg) / leg.squaredNorm() : 0;
    nearest_m = std::min(nearest_m, (a + std::clamp(along, 0.0, 1.0) * leg - p.head<2>()).norm());
  }
  return nearest_m;
}

/// `path` without its last stretch, as long as `goal` stays in sight.
nav::Path short_of(const nav::Path& path, const Vec3& goal, const map::VoxelMap& map) {
  nav::Path cut = path;
  while (cut.points.size() > 1) {
    const Vec3 from = cut.points[cut.points.size() - 2], to = cut.points.back();
    const auto steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / 0.1)));
    for (int i = steps; i >= 0; --i) {
      const Vec3 p = from + (to - from) * i / steps;
      if (!map.line_of_sight(p, goal, true)) return cut;
      cut.points.back() = p;
      if ((p - goal).norm() >= kBeforeSomebody_m) return cut;
    }
    cut.points.pop_back();
  }
  if (cut.points.size() == 1) cut.points.push_back(cut.points.front());
  return cut;
}

}  // namespace

Executive::Executive(const mission::Mission& mission, RobotId self)
    : self_(self),
      radius_m_(mission.robot(self).vehicle.radius_m),
      limits_(limits_of(mission.robot(self).vehicle)) {}

void Executive::on_inspected(const mission::Inspected& inspected) {
  if (!request_open_ || inspected.request != request_n_) return;
  request_open_ = false;
  progress_.inspected = inspected;
}

nav::State Executive::state(const Knowledge& k) const {
  const mission::Odometry& o = k.odometry();
  return {k.now(), o.pose.p, o.velocity_mps, o.pose.yaw_rad};
}

bool Executive::goes_first(const Knowledge& k, RobotId other) const {
  if (!k.mission().has(other)) return true;
  const auto rank = [&](RobotId id) { return std::pair(k.mission().robot(id).role, id); };
  return rank(self_) < rank(other);
}

void Executive::look_around(Knowledge& k) {
  const SimTime now = k.now();
  bodies_.forget(now);
  movers_.clear();
  note_silence(k);
  for (const auto& [id, mate] : k.teammates()) {
    if ((now - mate.heard).s() > kMoverMemory_s) continue;
    nav::Mover mover{id, mate.beacon.radius_m, {}};
    mover.announced.push_back({mate.beacon.mission_time, mate.beacon.pose.p,
                               mate.beacon.velocity_mps, mate.beacon.pose.yaw_rad});
    for (const mission::TimedPose& t : mate.beacon.trajectory) {
      if (t.t > mover.announced.back().t)
        mover.announced.push_back({t.t, t.pose.p, Vec3::Zero(), t.pose.yaw_rad});
    }
    note_standing(now, mate);
    movers_.push_back(std::move(mover));
  }
}

/// A teammate that should be near, in sight, and is not heard, while nobody else is either; or one
/// in the air that is seen and not heard, when nobody has been for a while: it may be the radio
/// that is silent, and they may move about unannounced.
void Executive::note_silence(const Knowledge& k) {
  const SimTime now = k.now();
  const double near_m = kWellHeard * k.mission().radio.range_m;
  double silent_s = std::numeric_limits<double>::infinity();
  bool missed = false;
  for (const auto& [id, mate] : k.teammates()) {
    const double this_s = (now - mate.heard).s();
    silent_s = std::min(silent_s, this_s);
    if (this_s <= kUnheard_s || this_s > 2 * kUnheard_s) continue;
    Vec3 at = mate.beacon.pose.p;
    for (const mission::TimedPose& t : mate.beacon.trajectory) {
      if (t.t <= now) at = t.pose.p;
    }
    missed = missed || ((at - k.position()).norm() < near_m &&
                        k.map().line_of_sight(at, k.position(), false));
  }
  missed = missed || bodies_.in_the_air(k.map(), {k.position(), near_m}, now);
  if (silent_s <= kUnheard_s) {
    radio_doubted_since_.reset();
  } else if (missed && !radio_doubted_since_) {
    radio_doubted_since_ = now;
    log::info("somebody is near and nobody is heard: waiting for the radio");
  }
}

/// Everybody who was near doubts it in the same moment and stands: nobody runs into anybody. Who
/// has waited in vain goes on looking where it flies.
bool Executive::waits_for_radio(SimTime now) const {
  return radio_doubted_since_ && (now - *radio_doubted_since_).s() < kWaitForRadio_s;
}

/// Teammates who are on their way and yet stand still: somebody may be in their way.
void Executive::note_standing(SimTime now, const Teammate& mate) {
  using mission::Activity;
  const mission::Beacon& b = mate.beacon;
  const bool on_its_way = b.activity == Activity::kTravelling ||
                          b.activity == Activity::kReturning || b.activity == Activity::kExploring;
  const bool stands =
      b.velocity_mps.norm() < 0.05 &&
      (b.trajectory.empty() || (b.trajectory.back().pose.p - b.pose.p).norm() < 0.05);
  if (on_its_way && stands)
    standing_since_.try_emplace(b.envelope.src, now);
  else
    standing_since_.erase(b.envelope.src);
}

/// Who has nothing to do here makes room for a neighbour that is on its way and cannot go on.
void Executive::make_room(Knowledge& k, Commands& commands) {
  const SimTime now = k.now();
  const auto state = k.odometry().state;
  if (now < room_again_ || !resting(now) || request_open_ || limits_.ground ||
      state == mission::VehicleState::kLanded || state == mission::VehicleState::kLanding)
    return;
  for (const nav::Mover& m : movers_) {
    const auto since = standing_since_.find(m.robot);
    if (since == standing_since_.end() || (now - since->second).s() < kMakeRoomAfter_s) continue;
    if ((m.announced.back().p - k.position()).norm() > kMakeRoomWithin_m) continue;
    blocked_by_ = m.robot;
    room_again_ = now + Duration::from_s(kMakeRoomPause_s);
    step_aside(k, commands);
    blocked_since_.reset();
    return;
  }
}

/// Who rests below one that may come down gets out of its way.
void Executive::dodge(Knowledge& k, Commands& commands) {
  const auto state = k.odometry().state;
  if (limits_.ground || state == mission::VehicleState::kLanded || !resting(k.now())) return;
  const auto above = k.silent_above(2 * radius_m_ + kFlyMargin_m);
  if (!above) return;
  blocked_by_ = *above;
  step_aside(k, commands);
}

/// The way it came, and on the way back what is left of it.
void Executive::remember(const Vec3& here) {
  const auto off_m = [&](std::size_t from_end) {
    return (here - trail_[trail_.size() - from_end]).norm();
  };
  while (backing_out_ && trail_.size() > 1 && off_m(2) <= off_m(1)) trail_.pop_back();
  if (backing_out_ || (!trail_.empty() && off_m(1) < kTrailStep_m)) return;
  if (trail_.size() == kTrail) trail_.erase(trail_.begin(), trail_.begin() + kTrail / 2);
  trail_.push_back(here);
}

/// Our process got no time, and the vehicle, left alone, has stopped and may be landing: what was
/// being flown is over.
void Executive::forget_flight(const Knowledge& k) {
  trajectory_ = {};
  plan_due_ = intent_.kind != Intent::Kind::kHover;
  landing_ = landing_ && k.odometry().state == mission::VehicleState::kLanded;
}

Executive::Commands Executive::step(Knowledge& k, const Intent& intent) {
  Commands commands;
  const SimTime now = k.now();
  if (now - stepped_at_ > kLeftAlone) forget_flight(k);
  remember(k.position());
  stepped_at_ = now;
  progress_.inspected = request_open_ ? std::nullopt : std::move(progress_.inspected);
  look_around(k);

  if (!same_goal(intent, intent_)) {
    if (request_open_) {
      commands.inspect = mission::Inspect{};  // cancels
      request_open_ = false;
    }
    progress_.inspected.reset();
    plan_due_ = intent.kind != Intent::Kind::kHover;
    if (intent.kind == Intent::Kind::kHover && !resting(now)) brake(k, commands);
    blocked_since_.reset();
    landing_ = false;
    transit_stuck_ = 0;
    partial_ = false;
    no_way_ = 0;
    way_done_ = false;
    landing_at_.reset();
    landing_tries_ = 0;
    progress_.state = Progress::State::kMoving;
  }
  intent_ = intent;

  const bool safe = stay_safe(k, commands);
  if (!aside_until_) dodge(k, commands);
  if (aside_until_) {
    if (now < *aside_until_) return commands;
    aside_until_.reset();
    plan_due_ = true;
  }
  if (intent.kind == Intent::Kind::kHover) {
    progress_.state = Progress::State::kIdle;
    blocked_since_.reset();
    make_room(k, commands);
    return commands;
  }
  if (!safe) return commands;

  const Vec3 goal = landing_at_.value_or(intent.goal.p);
  const double off_m = (k.position() - goal).norm();
  const double off_rad =
      intent.use_yaw ? std::abs(wrap_angle(k.odometry().pose.yaw_rad - intent.goal.yaw_rad)) : 0;
  const bool precise = intent.use_yaw || intent.kind != Intent::Kind::kGo;
  const bool near = off_m <= (precise ? std::min(intent.tolerance_m, 0.3) : intent.tolerance_m) ||
                    (way_done_ && off_m <= kNextToGoal_m) ||
                    (to_meet(intent) && way_done_ && off_m <= 2 * kBeforeSomebody_m);
  const bool there = near && off_rad <= kSettled_rad;

  if (there && resting(now)) {
    progress_.state = Progress::State::kArrived;
    blocked_since_.reset();
    plan_due_ = false;
    if (intent.kind == Intent::Kind::kInspect && !request_open_ && !progress_.inspected) {
      commands.inspect =
          mission::Inspect{{}, ++request_n_, intent.area_position, k.mission().inspect.hold_s};
      request_open_ = true;
    }
    if (intent.kind == Intent::Kind::kLand && !landing_ && !limits_.ground &&
        landing_tries_ < kLandingTries && taken(k.map(), k.position())) {
      if (now >= plan_again_) find_landing(k, intent, commands);
      return commands;
    }
    if (intent.kind == Intent::Kind::kLand && !landing_) {
      landing_ = true;
      mission::Trajectory land;
      land.id = ++trajectory_n_;
      land.land = true;
      commands.trajectory = land;
      trajectory_ = {};
    }
    if (intent.kind == Intent::Kind::kGo) make_room(k, commands);
    return commands;
  }
  if (landing_) return commands;

  if (waits_for_radio(now)) {
    plan_due_ = true;
    if (!resting(now) && now == *radio_doubted_since_) brake(k, commands);
    return commands;
  }

  const bool retry = now >= plan_again_ && (resting(now) || partial_);
  if (plan_due_ || retry) {
    plan_due_ = false;
    plan_again_ = now + Duration::from_s(kRetry_s);
    Intent there_too = intent;
    there_too.goal.p = goal;
    plan(k, there_too, commands);
  }
  if (blocked_since_ && blocked_by_ != kNoRobot && resting(now)) {
    const double patience_s = kStepAsideAfter_s * (goes_first(k, blocked_by_) ? 2 : 1);
    if ((now - *blocked_since_).s() > patience_s) step_aside(k, commands);
  }
  progress_.blocked_s = blocked_since_ ? (now - *blocked_since_).s() : 0;
  return commands;
}

std::vector<mission::TimedPose> Executive::announcement(SimTime now) const {
  std::vector<mission::TimedPose> announced;
  if (trajectory_.empty()) return announced;
  for (int i = 1; i * kAnnounceStep_s <= kAnnounceSpan_s; ++i) {
    const SimTime at = now + Duration::from_s(i * kAnnounceStep_s);
    const nav::State s = trajectory_.at(at);
    announced.push_back({at, {s.p, s.yaw_rad}});
    if (at >= trajectory_.end()) break;
  }
  return announced;
}

/// The one that we follow too closely: should it brake, braking a little later would not do, and
/// braking now helps.
std::optional<RobotId> Executive::follows_too_closely(const Knowledge& k) const {
  const SimTime now = k.now();
  if (movers_.empty()) return std::nullopt;
  const nav::Trajectory at_once = nav::braking_late(trajectory_, now, kTick, limits_);
  const nav::Trajectory late = nav::braking_late(trajectory_, now, kReaction, limits_);
  for (const nav::Mover& m : movers_) {
    if ((m.announced.front().p - k.position()).norm() > kFollows_m) continue;
    if (nav::speed(m, now) < kMoves_mps) continue;  // what stands is checked as it is
    const nav::Mover halted = nav::braking(m, now, limits_of(k.mission().robot(m.robot).vehicle));
    const auto gap_m = [&](const nav::Trajectory& halt) {
      return nav::least_gap(halt, radius_m_, halted, now, kForesight);
    };
    const double late_m = gap_m(late);
    if (late_m < kHeadway_m && gap_m(at_once) > late_m + 0.01) return m.robot;
  }
  return std::nullopt;
}

/// Checks what is being flown; true when it may go on being flown (or the vehicle rests).
bool Executive::stay_safe(Knowledge& k, Commands& commands) {
  const SimTime now = k.now();
  if (resting(now)) return true;
  if (const auto ahead = follows_too_closely(k)) {
    brake(k, commands);
    blocked(now, "too close behind robot " + std::to_string(ahead->value), *ahead);
    plan_again_ = now + Duration::from_s(kRetry_s);
    return false;
  }
  const bool due = k.map().revision() != checked_revision_ ||
                   (now - checked_at_).s() >= kRecheck_s - 1e-9 || !bodies_.spheres().empty();
  if (!due) return true;
  checked_revision_ = k.map().revision();
  checked_at_ = now;
  const auto unsafe = backing_out_ ? nav::check_others(trajectory_, now, radius_m_, movers_,
                                                       bodies_.spheres(), kFlyMargin_m)
                                   : nav::check(trajectory_, now, k.map(), radius_m_, movers_,
                                                bodies_.spheres(), kFlyMargin_m);
  if (!unsafe) return true;

  const double ahead_s = (unsafe->t - now).s();
  const double stop_s = k.odometry().velocity_mps.norm() / limits_.accel_mps2;
  if (unsafe->robot != kNoRobot && goes_first(k, unsafe->robot) && ahead_s > stop_s + 1.2)
    return true;  // the other one yields
  if (ahead_s > stop_s + 2.0) {
    plan_due_ = true;  // far enough ahead to find another way while moving
    return true;
  }
  brake(k, commands);
  blocked(now, "unsafe ahead: " + unsafe->with, unsafe->robot);
  plan_again_ = now + Duration::from_s(kRetry_s);
  return false;
}

/// Bodies that a way has to go round; the search adds our own body and clearance to them.
std::vector<map::Sphere> Executive::parked(SimTime now) const {
  std::vector<map::Sphere> spheres = bodies_.spheres();
  for (map::Sphere& s : spheres) s.radius_m += kPlanMargin_m - kMapClearance_m;
  for (const nav::Mover& m : movers_) {
    if (m.announced.back().t > now + Duration::from_s(1)) continue;
    spheres.push_back({m.announced.back().p, m.radius_m + kPlanMargin_m - kMapClearance_m + 0.02});
  }
  return spheres;
}

void Executive::plan(Knowledge& k, const Intent& intent, Commands& commands) {
  if (rise_as_it_came(k, commands)) return;
  if (intent.through_unknown) {
    plan_transit(k, intent, commands);
    return;
  }
  const double tolerance_m = std::clamp(intent.tolerance_m, 0.3, 1.5);
  const std::vector<map::Sphere> around = parked(k.now());
  const auto found = k.paths().find(k.position(), intent.goal.p, tolerance_m, around);
  if (found.path) {
    no_way_ = 0;
    fly(k, *found.path, intent, commands);
    return;
  }
  if (rise(k, commands)) return;
  no_way(k);
  // Parked teammates may be all that is in the way.
  RobotId by = kNoRobot;
  if (!around.empty() && k.paths().find(k.position(), intent.goal.p, tolerance_m).path) {
    double nearest = 1e9;
    for (const nav::Mover& m : movers_) {
      const double d = (m.announced.back().p - k.position()).norm();
      if (d < nearest) nearest = d, by = m.robot;
    }
  }
  blocked(k.now(), found.reason, by);
}

void Executive::plan_transit(Knowledge& k, const Intent& intent, Commands& commands) {
  const SimTime now = k.now();
  std::erase_if(avoid_, [&](const auto& a) { return a.second < now; });
  std::vector<map::Sphere> avoid;
  for (const auto& [sphere, until] : avoid_) avoid.push_back(sphere);
  const auto way = k.paths().find_through_unknown(
      k.position(), intent.goal.p, std::clamp(intent.tolerance_m, 0.3, 1.5), avoid, parked(now));
  partial_ = false;
  if (!way.path) {
    if (rise(k, commands)) return;
    if (avoid_.empty()) blocked(now, way.reason);
    avoid_.clear();
    no_way(k);
    return;
  }
  no_way_ = 0;
  if (way.known.points.empty()) return;
  if ((way.known.points.back() - way.path->points.back()).norm() < 0.05) {
    fly(k, way.known, intent, commands);
    return;
  }
  partial_ = true;
  plan_again_ = now + Duration::from_s(kTransitReplan_s);
  if (way.known.length_m() > 0.3) {
    if ((k.position() - transit_from_).norm() > 0.5) {
      transit_stuck_ = 0;
      transit_from_ = k.position();
    }
    if (resting(now)) ++transit_stuck_;
    Intent part = intent;
    part.use_yaw = false;
    fly(k, way.known, part, commands);
    return;
  }
  // At the edge of what is known: look at what comes next; when looking does not help, go round.
  if (!resting(now)) return;
  Vec3 next = way.path->points.back();
  for (const Vec3& p : way.path->points) {
    if ((p - k.position()).norm() > 0.5) {
      next = p;
      break;
    }
  }
  if (++transit_stuck_ > 4) {
    const Vec3 towards = (next - k.position()).normalized();
    avoid_.push_back({{k.position() + 0.7 * towards, 0.5}, now + Duration::from_s(30)});
    transit_stuck_ = 0;
  }
  const Vec3 d = next - k.position();
  if (d.head<2>().norm() > 0.1) turn(k, std::atan2(d.y(), d.x()), commands);
}

bool Executive::fly(Knowledge& k, const nav::Path& whole, const Intent& intent,
                    Commands& commands) {
  const nav::Path path =
      to_meet(intent) && !partial_ ? short_of(whole, intent.goal.p, k.map()) : whole;
  way_done_ = !partial_ && path.length_m() < 0.05;
  std::optional<double> yaw;
  if (intent.use_yaw) yaw = intent.goal.yaw_rad;
  const bool look_ahead = !may_look_away(k, intent, path);
  std::optional<nav::Unsafe> unsafe;
  for (const double scale : {1.0, 0.5}) {
    for (const double corner_m : kCorners_m) {
      nav::Trajectory t =
          nav::time_path(path, {state(k), yaw, scale, look_ahead}, limits_, corner_m);
      unsafe =
          nav::check(t, k.now(), k.map(), radius_m_, movers_, bodies_.spheres(), kPlanMargin_m);
      if (!unsafe) {
        pressed_ = 0;
        set_out(k, std::move(t), commands);
        return true;
      }
      if (unsafe->with != "map") break;
    }
    if (unsafe->robot == kNoRobot) break;
  }
  // What is being flown has been checked already; from rest, wait.
  if (!resting(k.now())) return false;
  if (unsafe->with == "map") {
    if (rise(k, commands)) return true;
    if (!k.map().traversable(k.position()) && ++pressed_ > kPressed && back_out(k, commands))
      return true;
  }
  blocked(k.now(), "unsafe: " + unsafe->with, unsafe->robot);
  return false;
}

/// Whether the camera may turn on the way to what it will be needed for. Who explores is mostly
/// alone; the radio, if it works, tells of teammates that move, and what stands about unannounced
/// has been seen or has nothing to stand on.
bool Executive::may_look_away(const Knowledge& k, const Intent& intent,
                              const nav::Path& path) const {
  if (!intent.use_yaw || intent.activity != mission::Activity::kExploring || radio_doubted_since_)
    return false;
  bool radio_works = false, silent = false;
  for (const auto& [id, mate] : k.teammates()) {
    const double silent_s = (k.now() - mate.heard).s();
    radio_works = radio_works || silent_s < kRadioWorks_s;
    // Who fell silent near by went away, or came down, or will.
    silent = silent || (silent_s > kSilentFrom_s && silent_s < kSilentUntil_s &&
                        level_distance_m(path, mate.beacon.pose.p) < kSilentNear_m);
  }
  return radio_works && !silent && lookout_.clear(path, k.map(), k.now(), radius_m_);
}

/// Who rests close to something, as after coming down without a process, has a way out that may
/// lead past it, and nearer. A body that came down can go up again.
bool Executive::rise(Knowledge& k, Commands& commands) {
  const Vec3 here = k.position();
  if (!resting(k.now()) || k.config().vehicle.ground || k.map().traversable(here)) return false;
  const double edge_m = k.map().config().resolution_m;
  for (int up = 1; up * edge_m <= kRise_m; ++up) {
    const Vec3 above = here + up * edge_m * Vec3::UnitZ();
    if (!k.map().traversable(above)) continue;
    nav::Trajectory t = nav::time_path({{here, above}}, {state(k), std::nullopt, 0.5}, limits_);
    if (nav::check(t, k.now(), k.map(), radius_m_, movers_, bodies_.spheres(), kPlanMargin_m))
      return false;
    set_out(k, std::move(t), commands);
    return true;
  }
  return false;
}

/// True while it has not risen yet, as far as others leave room.
bool Executive::rise_as_it_came(Knowledge& k, Commands& commands) {
  if (rise_first_ && (k.position() - *rise_first_).head<2>().norm() > kSettled_m)
    rise_first_.reset();  // it made room for somebody
  if (!rise_first_) return false;
  const nav::Path up{{k.position(), *rise_first_}};
  nav::Trajectory t = nav::time_path(up, {state(k), std::nullopt, 0.5}, limits_);
  if (nav::check_others(t, k.now(), radius_m_, movers_, bodies_.spheres(), kPlanMargin_m)) {
    plan_again_ = k.now() + Duration::from_s(kRetry_s);
    return true;
  }
  rise_first_.reset();
  set_out(k, std::move(t), commands);
  backing_out_ = true;  // where it has been
  return true;
}

/// On its way, and blocked no longer.
void Executive::set_out(Knowledge& k, nav::Trajectory trajectory, Commands& commands) {
  blocked_since_.reset();
  command(k, std::move(trajectory), commands);
  progress_.state = Progress::State::kMoving;
}

/// A robot came to where it is, so the way it came is free, whatever the map has learned since:
/// from somebody who saw it stand and did not hear it, or because a voxel is wider than what it
/// shows. Back to where the map leaves room.
bool Executive::back_out(Knowledge& k, Commands& commands) {
  const Vec3 here = k.position();
  nav::Path way{{here}};
  const auto room = std::find_if(trail_.rbegin(), trail_.rend(), [&](const Vec3& p) {
    if ((p - way.points.back()).norm() >= kTrailStep_m / 2) way.points.push_back(p);
    return (p - here).norm() >= kBackOut_m && k.map().traversable(p);
  });
  if (room == trail_.rend()) return false;
  nav::Trajectory t = nav::time_path(way, {state(k), std::nullopt, 0.5}, limits_, kCorners_m[2]);
  if (nav::check_others(t, k.now(), radius_m_, movers_, bodies_.spheres(), kPlanMargin_m))
    return false;
  pressed_ = 0;
  set_out(k, std::move(t), commands);
  backing_out_ = true;
  return true;
}

/// The next search waits longer, the oftener there was no way.
void Executive::no_way(Knowledge& k) {
  plan_again_ = k.now() + Duration::from_s(std::min(kNoWayLongest_s, kNoWay_s * (1 << no_way_)));
  no_way_ = std::min(no_way_ + 1, 4);
  if (no_way_ > 2 && resting(k.now()) && k.paths().confined(k.position(), kWayOut_m))
    k.map().disbelieve_others(k.position(), radius_m_ + kOwnImage_m);
}

/// Something stands where a landing at `p` would come down: it rises from the ground around.
bool Executive::taken(const map::VoxelMap& map, const Vec3& p) const {
  constexpr double kAround_m = 1.0, kDown_m = 2.0, kRises_m = 0.35;
  const double edge_m = map.config().resolution_m;
  const double lowest_z = map.config().bounds.low().z();
  double ground_z = p.z(), top_z = p.z() - kDown_m;
  const int around = static_cast<int>(kAround_m / edge_m);
  for (int ix = -around; ix <= around; ++ix) {
    for (int iy = -around; iy <= around; ++iy) {
      const double dx = ix * edge_m, dy = iy * edge_m;
      for (int iz = 0; iz * edge_m < kDown_m; ++iz) {
        const double z = p.z() - iz * edge_m;
        if (map.at(Vec3(p.x() + dx, p.y() + dy, z)) != map::Voxel::kOccupied) continue;
        ground_z = std::min(ground_z, z);
        if (std::hypot(dx, dy) < radius_m_ + edge_m) top_z = std::max(top_z, z);
      }
    }
  }
  ground_z = std::max(ground_z, lowest_z);  // depth noise reaches below the site
  return top_z > ground_z + kRises_m || bodies_.below(p, radius_m_);
}

/// Its own place is taken: the nearest one beside it that is nobody's.
void Executive::find_landing(Knowledge& k, const Intent& intent, Commands& commands) {
  plan_again_ = k.now() + Duration::from_s(kNoWay_s);
  ++landing_tries_;
  for (const double radius : {1.0, 1.2, 1.45, 1.8, 2.4}) {
    for (int i = 0; i < 16; ++i) {
      const double a = i * std::numbers::pi / 8;
      const Vec3 spot = intent.goal.p + radius * Vec3(std::cos(a), std::sin(a), 0);
      const auto& fleet = k.mission().fleet;
      const bool owned = std::any_of(fleet.begin(), fleet.end(), [&](const auto& r) {
        return r.id != self_ && (r.start.p - spot).template head<2>().norm() < kNeighbour_m;
      });
      if (owned || taken(k.map(), spot) || !k.map().traversable(spot)) continue;
      const auto found = k.paths().find(k.position(), spot, 0.1, bodies_.spheres());
      if (!found.path) continue;
      Intent beside = intent;
      beside.goal.p = spot;
      if (!fly(k, *found.path, beside, commands)) continue;
      landing_at_ = spot;
      return;
    }
  }
}

void Executive::step_aside(Knowledge& k, Commands& commands) {
  Vec3 away = Vec3::Zero();
  for (const nav::Mover& m : movers_) {
    if (m.robot == blocked_by_) away = k.position() - m.announced.back().p;
  }
  away.z() = 0;
  const double base = away.norm() > 1e-3 ? std::atan2(away.y(), away.x()) : 0;
  for (const double radius : {2.5, 1.5, 4.0}) {
    for (const int turn_deg : {60, -60, 0, 30, -30, 90, -90, 120, -120, 150, -150, 180}) {
      const double a = base + turn_deg * std::numbers::pi / 180;
      const Vec3 goal = k.position() + radius * Vec3(std::cos(a), std::sin(a), 0);
      if (!k.map().traversable(goal)) continue;
      const auto found = k.paths().find(k.position(), goal, 0.3);
      if (!found.path || found.path->length_m() > 2 * radius) continue;
      nav::Trajectory t = nav::time_path(*found.path, {state(k), std::nullopt, 1}, limits_);
      if (nav::check(t, k.now(), k.map(), radius_m_, movers_, bodies_.spheres(), kPlanMargin_m))
        continue;
      aside_until_ = t.end() + Duration::from_s(goes_first(k, blocked_by_) ? 0.5 : 2.0);
      blocked_since_.reset();
      command(k, std::move(t), commands);
      return;
    }
  }
  blocked_since_ = k.now();  // no room to step aside: wait on
}

void Executive::turn(Knowledge& k, double yaw_rad, Commands& commands) {
  const nav::State here = state(k);
  const double turn_rad = std::abs(wrap_angle(yaw_rad - here.yaw_rad));
  if (turn_rad < kSettled_rad || here.v_mps.norm() > 0.05) return;
  nav::State end = here;
  end.v_mps.setZero();
  end.yaw_rad = yaw_rad;
  end.t = here.t + Duration::from_s(turn_rad / limits_.yaw_rate_radps + 0.1);
  nav::State begin = here;
  begin.v_mps.setZero();
  command(k, nav::Trajectory({begin, end}), commands);
}

void Executive::brake(Knowledge& k, Commands& commands) {
  command(k, nav::stop(state(k), limits_), commands);
}

void Executive::command(Knowledge& k, nav::Trajectory trajectory, Commands& commands) {
  trajectory_ = std::move(trajectory);
  backing_out_ = false;
  checked_revision_ = k.map().revision();
  checked_at_ = k.now();
  mission::Trajectory message;
  message.id = ++trajectory_n_;
  for (const nav::State& s : trajectory_.states())
    message.states.push_back({s.t, s.p, s.v_mps, s.yaw_rad});
  commands.trajectory = std::move(message);
}

void Executive::blocked(SimTime now, std::string reason, RobotId by) {
  if (!blocked_since_) blocked_since_ = now;
  blocked_by_ = by;
  progress_.state = Progress::State::kBlocked;
  progress_.reason = std::move(reason);
}

}  // namespace muster::robot
