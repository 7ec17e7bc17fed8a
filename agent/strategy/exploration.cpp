#include "agent/strategy/exploration.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/log.h"
#include "common/robot/stopwatch.h"
#include "common/route/explore_order.h"

namespace muster::agent {
namespace {

constexpr double kNearFlood_m =
    14;                           // how far path lengths are exact while something is left near by
constexpr double kDetour = 1.25;  // path over straight line, where only the straight line is known
constexpr double kBlocked_s = 3;
constexpr double kBarred_s = 25;
constexpr double kDecide_s = 1.0;
constexpr double kSurfaceStay_s = 7;  // a look comes every 2 s: at most three from one place
constexpr double kSurfaceWaits_s = 8, kGainWorth_sPerM2 = 0.2, kGainCap_m2 = 6;
constexpr std::uint32_t kNearest = 7;  // FIELD-NOTES: FF3E exact for at most 7 nearest clusters

map::TargetConfig target_config(const mission::Mission& mission, const mission::Vehicle& vehicle) {
  map::TargetConfig c;
  c.camera = vehicle.camera;
  c.pitch_rad = vehicle.pitch_rad;
  c.look_range_m = mission.sensing.sighting_range_m - 0.5;
  return c;
}

}  // namespace

Exploration::Exploration(robot::Knowledge& k, RegionId region)
    : region_(region),
      since_(k.now()),
      targets_(k.map(), k.mission().boxes.at(region.value),
               target_config(k.mission(), k.config().vehicle)),
      watched_(k.map().watch(k.mission().boxes.at(region.value))) {}

void Exploration::on_scan(robot::Knowledge& k, const mission::Scan& scan) {
  (void)k;
  targets_.scanned(scan.sensor);
  ++scans_;
}

bool Exploration::barred(const Vec3& p, SimTime now) const {
  return std::any_of(barred_.begin(), barred_.end(),
                     [&](const auto& b) { return b.second > now && (b.first - p).norm() < 0.7; });
}

robot::Intent Exploration::fly_to(const map::Viewpoint& v) const {
  robot::Intent intent;
  intent.kind = robot::Intent::Kind::kGo;
  intent.goal = v.pose;
  intent.use_yaw = true;
  intent.activity = mission::Activity::kExploring;
  intent.reason = v.surface
                      ? "looking once more at surfaces of region " + std::to_string(region_.value)
                      : "frontier of region " + std::to_string(region_.value);
  return intent;
}

/// Brings the targets up to date. Thorough: reachability by a full flood instead of one of the
/// surroundings.
void Exploration::refresh(robot::Knowledge& k, bool thorough,
                          std::vector<mission::PlanningTime>& planning) {
  const robot::Stopwatch watch(planning, mission::PlanningStep::kFrontier);
  nav::PathFinder& paths = k.paths();
  paths.flood(k.position(), thorough ? 1e9 : kNearFlood_m);
  const Vec3 here = k.position();
  targets_.update([&](const Vec3& p) {
    if (!thorough && (p - here).norm() > kNearFlood_m / kDetour)
      return true;  // told by the thorough round
    return paths.reached(p);
  });
  refreshed_scans_ = scans_;
}

bool Exploration::worth_keeping(const robot::Knowledge& k, const robot::Progress& progress) {
  if (!goal_) return false;
  if (progress.blocked_s > kBlocked_s) {
    barred_.push_back({goal_->pose.p, k.now() + Duration::from_s(kBarred_s)});
    return false;
  }
  const map::Viewpoint* still = nullptr;
  for (const map::Viewpoint& v : targets_.viewpoints()) {
    const bool same = v.surface == goal_->surface && (v.pose.p - goal_->pose.p).norm() < 0.7 &&
                      std::abs(wrap_angle(v.pose.yaw_rad - goal_->pose.yaw_rad)) < 0.6;
    if (same && (!still || v.gain > still->gain)) still = &v;
  }
  if (progress.state != robot::Progress::State::kArrived) {
    arrived_.reset();
    return still != nullptr;
  }
  if (!arrived_) {
    arrived_ = k.now();
    arrived_scans_ = scans_;
  }
  if (goal_->surface) return still && (k.now() - *arrived_).s() < kSurfaceStay_s;
  return scans_ < arrived_scans_ + 1;  // one scan from here, taken at rest
}

bool Exploration::choose(robot::Knowledge& k, double budget_s, const Vec3& meeting,
                         std::vector<mission::PlanningTime>& planning) {
  const robot::Stopwatch watch(planning, mission::PlanningStep::kExplore);
  struct Candidate {
    const map::Viewpoint* v;
    double travel_s;
  };
  const nav::Limits& limits = k.limits();
  const auto seconds = [&](const Vec3& a, const Vec3& b) {
    return nav::travel_time_s(kDetour * (a - b).norm(), limits);
  };
  std::vector<Candidate> candidates;
  for (const map::Viewpoint& v : targets_.viewpoints()) {
    if (barred(v.pose.p, k.now())) continue;
    const double path_m = k.paths().flood_distance(v.pose.p);
    const double travel_s = std::isfinite(path_m) ? nav::travel_time_s(path_m, limits)
                                                  : 1.5 * seconds(k.position(), v.pose.p);
    const double turn_s =
        std::abs(wrap_angle(v.pose.yaw_rad - k.odometry().pose.yaw_rad)) / limits.yaw_rate_radps;
    // Places are ranked by the time they cost: gain is worth a detour, a surface waits while
    // frontiers are near.
    const double wait_s = v.surface ? kSurfaceWaits_s : 0;
    const double worth_s = kGainWorth_sPerM2 * std::min(v.gain, kGainCap_m2);
    candidates.push_back({&v, std::max(0.05, std::max(travel_s, turn_s) + wait_s - worth_s)});
  }
  if (candidates.empty()) return false;
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.travel_s < b.travel_s; });
  candidates.resize(std::min<std::size_t>(candidates.size(), kNearest));

  const std::size_t n = candidates.size();
  route::OrderProblem problem;
  problem.budget_s = budget_s;
  problem.meeting = std::isfinite(budget_s);
  const std::size_t size = n + 1 + (problem.meeting ? 1 : 0);
  problem.travel_s.assign(size, std::vector<double>(size, 0));
  const auto place = [&](std::size_t i) {
    return i == 0 ? k.position() : i <= n ? candidates[i - 1].v->pose.p : meeting;
  };
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < size; ++j) problem.travel_s[i][j] = seconds(place(i), place(j));
  }
  for (std::size_t i = 0; i < n; ++i) {
    problem.travel_s[0][i + 1] = problem.travel_s[i + 1][0] = candidates[i].travel_s;
    problem.gain.push_back(candidates[i].v->gain);
  }
  // Alg. 1 takes the longest way that still makes the meeting. That is only sensible when not
  // everything can be visited before it; otherwise the shortest way through all of it leaves more
  // time for what will be seen next.
  const route::Order all = route::shortest_order(problem);
  const route::Order order = all.length_s <= budget_s ? all : route::ff3e(problem, kNearest);
  if (order.visit.empty()) return false;
  goal_ = *candidates[order.visit.front()].v;
  log::debug(
      "choose {} gain {:.2f} travel {:.1f} of {} (nearest {:.1f}) known {:.0f} frontier {:.0f} "
      "owed {:.0f} d {:.2f}",
      goal_->surface ? "S" : "F", goal_->gain, candidates[order.visit.front()].travel_s,
      targets_.viewpoints().size(), candidates[0].travel_s, known_m3(k), targets_.frontier_m2(),
      targets_.owed_surface_m2(), (goal_->pose.p - k.position()).norm());
  arrived_.reset();
  return true;
}

std::optional<robot::Intent> Exploration::next(robot::Knowledge& k, const robot::Progress& progress,
                                               double budget_s, const Vec3& meeting,
                                               std::vector<mission::PlanningTime>& planning) {
  const SimTime now = k.now();
  const bool fresh = scans_ != refreshed_scans_;
  const bool due = fresh && (now >= decide_again_ ||
                             progress.state == robot::Progress::State::kArrived || !goal_);
  if (due) {
    refresh(k, thorough_, planning);
    decide_again_ = now + Duration::from_s(kDecide_s);
  }
  if (due || progress.blocked_s > kBlocked_s) {
    if (!worth_keeping(k, progress)) {
      goal_.reset();
      if (choose(k, budget_s, meeting, planning)) {
        empty_rounds_ = 0;
        thorough_ = false;
      } else if (due) {
        // Nothing near: look again with reachability known everywhere before saying so.
        const bool was_thorough = std::exchange(thorough_, true);
        entered_ = entered_ || known_m3(k) > 1.0;
        if (was_thorough && entered_ && targets_.done() && ++empty_rounds_ >= 2) done_ = true;
      }
    }
  }
  if (goal_) return fly_to(*goal_);
  if (done_) return std::nullopt;
  if (targets_.viewpoints().empty() && known_m3(k) < 1.0) {
    // Nothing of the box is known yet: go there, sensing the way.
    robot::Intent intent;
    intent.kind = robot::Intent::Kind::kGo;
    Box inner = k.mission().boxes[region_.value];
    inner.size = (inner.size - Vec3::Constant(1.6)).cwiseMax(0.2);
    intent.goal.p = inner.closest(k.position());
    intent.through_unknown = true;
    intent.tolerance_m = 1.0;
    intent.activity = mission::Activity::kTravelling;
    intent.reason = "on the way to region " + std::to_string(region_.value);
    return intent;
  }
  return std::nullopt;
}

}  // namespace muster::agent
