#include "agent/strategy/exploration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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
constexpr double kPatience = 2;  // times what the way should take, and a stay
constexpr double kRefresh_s = 1.2;
constexpr double kSurfaceStay_s = 7;  // a look comes every 2 s: at most three from one place
constexpr double kLeftover = 4;       // m³ that a cluster is worth for being done with
// A cluster is looked at for so many finds, if surfaces hide as many areas as those seen so far,
// beginning with two on 100 m².
constexpr double kFindsPerLook = 0.0024, kAreasBefore = 2, kSurfaceBefore_m2 = 100;
constexpr double kThorough_m2 = 0.12, kCursory_m2 = 0.3;
constexpr double kSmall = 7;                // value: leftovers and little else
constexpr std::size_t kManyLeftovers = 80;  // the nearest
constexpr double kRoundabout = 2;           // where the straight way is not free
constexpr double kDepth_m = 2.5;            // unknown volume behind a frontier, over its area
constexpr double kProgress = 0.3;           // of the looks that were promised: less was in vain
constexpr double kStop_s = 1;               // to look, beside the way
constexpr std::size_t kLookedInto = 12;     // viewpoints of clusters, per decision
constexpr double kUsedUp = 0.35;            // of its value at choice: on to the next
constexpr double kComparable = 0.9;         // of the best rate: these are put in order
constexpr std::uint32_t kNearest = 7;  // FIELD-NOTES: FF3E exact for at most 7 nearest clusters

/// Where only the straight way is known, at rest at both ends.
double roughly_s(const Pose& from, const Vec3& to, double yaw_rad, const nav::Limits& limits) {
  return flight_s(kDetour * (to - from.p).norm(), to - from.p, from.yaw_rad, yaw_rad, limits);
}

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
      vantages_(k.mission().boxes.at(region.value), k.map()),
      watched_(k.map().watch(k.mission().boxes.at(region.value))),
      look_period_s_(1 / k.mission().sensing.sighting_rate_hz),
      last_look_(k.now()) {
  recall(k);
}

/// A surface that becomes known is credited with these looks as with later ones. (What a look on
/// nobody's behalf sighted is lost: it has to be seen again.)
void Exploration::recall(const robot::Knowledge& k) {
  for (const auto& [explored, look] : k.looks()) {
    const bool lost = explored == kNoRegion && !look.seen.empty();
    if (!lost) count_look(k, look.sensor, look.pitch_rad);
  }
}

/// (Others look with cameras like this one.)
void Exploration::take_told_looks(const robot::Knowledge& k) {
  const std::vector<Pose>& told = k.told_looks();
  for (; told_looks_ < told.size(); ++told_looks_)
    count_look(k, told[told_looks_], k.config().vehicle.pitch_rad);
}

void Exploration::count_look(const robot::Knowledge& k, const Pose& sensor, double pitch_rad) {
  const Box& box = k.mission().boxes[region_.value];
  if (box.distance(sensor.p) < k.mission().sensing.sighting_range_m)
    targets_.looked(sensor, pitch_rad);
}

void Exploration::on_scan(const mission::Scan& scan) {
  targets_.scanned(scan.sensor);
  ++scans_;
}

void Exploration::on_look(const robot::Knowledge& k, const mission::Sightings& sightings) {
  targets_.looked(sightings.sensor, sightings.pitch_rad);
  last_look_ = k.now();
  ++looks_;
}

ViewPrice Exploration::price() const {
  ViewPrice p;
  p.look_period_s = look_period_s_;
  p.next_look = last_look_ + Duration::from_s(look_period_s_);
  return p;
}

bool Exploration::barred(const Pose& pose, SimTime now) const {
  return std::any_of(barred_.begin(), barred_.end(), [&](const Barred& b) {
    return b.until > now && (b.pose.p - pose.p).norm() < 0.7 &&
           std::abs(wrap_angle(b.pose.yaw_rad - pose.yaw_rad)) < b.off_rad;
  });
}

robot::Intent Exploration::fly_to(const Goal& goal) const {
  robot::Intent intent;
  intent.kind = robot::Intent::Kind::kGo;
  intent.goal = goal.view.pose;
  intent.use_yaw = true;
  intent.activity = mission::Activity::kExploring;
  intent.reason = goal.view.look ? "looking at surfaces of region " + std::to_string(region_.value)
                                 : "frontier of region " + std::to_string(region_.value);
  return intent;
}

/// How much of an unseen surface a look must promise: the less, the more is found here per area.
double Exploration::worth_looking_m2(const robot::Knowledge& k) const {
  const double per_m2 =
      (kAreasBefore + k.areas_in(region_).found) / (kSurfaceBefore_m2 + targets_.surface_m2());
  return std::clamp(kFindsPerLook / per_m2, kThorough_m2, kCursory_m2);
}

/// Brings clusters and their viewpoints up to date. Thorough: reachability by a full flood instead
/// of one of the surroundings.
void Exploration::refresh(robot::Knowledge& k, bool thorough,
                          std::vector<mission::PlanningTime>& planning) {
  const robot::Stopwatch watch(planning, mission::PlanningStep::kFrontier);
  targets_.ask_for(surveyed_ ? worth_looking_m2(k) : kCursory_m2, surveyed_);
  nav::PathFinder& paths = k.paths();
  paths.flood(k.position(), thorough ? 1e9 : kNearFlood_m);
  const Vec3 here = k.position();
  targets_.update([&](const Vec3& p) {
    if (!thorough && (p - here).norm() > kNearFlood_m / kDetour)
      return true;  // told by the thorough round
    return straight(k.map(), here, p) || paths.reached(p);
  });
  refreshed_scans_ = scans_;
  settled_ = scans_ + looks_;
}

/// What it promised has been seen on the way.
bool Exploration::used_up() const {
  const map::Worth left = targets_.worth(goal_->view.pose);
  const ViewPrice p;
  const double value = left.unknown_m3 + (goal_->view.look ? p.owed_weight * left.owed_m2 : 0);
  return value < kUsedUp * goal_->view.value;
}

bool Exploration::worth_keeping(const robot::Knowledge& k, const robot::Progress& progress) {
  if (!goal_) return false;
  const Pose& pose = goal_->view.pose;
  if (progress.blocked_s > kBlocked_s || k.now() > give_up_) {
    barred_.push_back({pose, std::numbers::pi + 1, k.now() + Duration::from_s(kBarred_s)});
    return false;
  }
  bool still = !goal_->cluster;
  for (const map::Viewpoint& v : targets_.viewpoints()) {
    still = still || (v.surface == goal_->surface && (v.pose.p - pose.p).norm() < 0.7 &&
                      std::abs(wrap_angle(v.pose.yaw_rad - pose.yaw_rad)) < 0.6);
  }
  if (goal_->cluster ? !still : used_up()) return false;
  if (progress.state != robot::Progress::State::kArrived) {
    arrived_.reset();
    return true;
  }
  if (!arrived_) {
    arrived_ = k.now();
    arrived_scans_ = scans_;
    arrived_looks_ = looks_;
    arrived_counted_ = targets_.looks_counted();
  }
  if (goal_->view.look && (k.now() - *arrived_).s() < kSurfaceStay_s) {
    if (looks_ == arrived_looks_) return true;
  } else if (scans_ == arrived_scans_) {
    return true;  // one scan from here, taken at rest
  }
  // It did all it could. What it promised and did not show, it will not show next time either.
  const bool no_volume =
      !goal_->cluster && targets_.worth(pose).unknown_m3 > 0.5 * goal_->view.worth.unknown_m3;
  const double cell_m2 = std::pow(k.map().config().resolution_m, 2);
  const double counted_m2 =
      static_cast<double>(targets_.looks_counted() - arrived_counted_) * cell_m2;
  // (A cluster that its viewpoint does not show is given up by the targets themselves.)
  const bool in_vain =
      goal_->view.look ? counted_m2 < kProgress * goal_->view.worth.owed_m2 + 0.1 : no_volume;
  if (in_vain && !goal_->cluster)
    barred_.push_back({pose, 0.5, k.now() + Duration::from_s(kBarred_s)});
  return false;
}

Exploration::Goal Exploration::cluster_goal(robot::Knowledge& k, const map::Viewpoint& v) {
  const Vec3 here = k.position(), d = v.pose.p - here;
  map::Worth worth = targets_.worth(v.pose);
  if (!v.surface || worth.owed_m2 > 0.3 * v.gain) worth.unknown_m3 += kLeftover;
  double way_m = d.norm();
  if (!straight(k.map(), here, v.pose.p)) {
    const double path_m =
        way_m < kNearFlood_m / kDetour ? k.paths().flood_distance(v.pose.p) : kDetour * way_m;
    way_m = std::isfinite(path_m) ? path_m : 1.5 * kDetour * way_m;
  }
  const double arrive_s = flight_s(way_m, d, k.odometry().pose.yaw_rad, v.pose.yaw_rad, k.limits(),
                                   k.odometry().velocity_mps);
  View view = agent::price(v.pose, worth, arrive_s, k.now(), price());
  view.look = view.look || v.surface;
  return {view, true, v.surface};
}

std::vector<Exploration::Goal> Exploration::candidates(robot::Knowledge& k) {
  const ViewPrice p = price();
  const SimTime now = k.now();
  const Vec3 here = k.position();
  std::vector<Goal> result;
  for (const View& v : vantages_.best(k, targets_, p, kNearest,
                                      [&](const Pose& pose) { return barred(pose, now); })) {
    result.push_back({v, false, false});
  }
  // Paths and views are worked out for those that may be the best: by their clusters' area and the
  // straight way.
  struct Rough {
    double rate;
    const map::Viewpoint* v;
  };
  std::vector<Rough> rough;
  for (const map::Viewpoint& v : targets_.viewpoints()) {
    if (barred(v.pose, now)) continue;
    const double value = kLeftover + (v.surface ? p.owed_weight : kDepth_m) * v.gain;
    const double way_s = nav::travel_time_s((v.pose.p - here).norm(), k.limits()) + kStop_s;
    rough.push_back({value / way_s, &v});
  }
  std::stable_sort(rough.begin(), rough.end(),
                   [](const Rough& a, const Rough& b) { return a.rate > b.rate; });
  rough.resize(std::min(rough.size(), kLookedInto));
  for (const Rough& r : rough) result.push_back(cluster_goal(k, *r.v));
  std::stable_sort(result.begin(), result.end(),
                   [](const Goal& a, const Goal& b) { return a.view.rate > b.view.rate; });
  return result;
}

/// When only small things are left, of which none is worth more than being done with, the shortest
/// way through all of them leaves the fewest long ways for the end: the first of it.
std::optional<Exploration::Goal> Exploration::leftover(robot::Knowledge& k, double budget_s,
                                                       const Vec3& meeting) {
  const Pose here = k.odometry().pose;
  std::vector<const map::Viewpoint*> views;
  for (const map::Viewpoint& v : targets_.viewpoints()) {
    if (!v.surface) return std::nullopt;
    if (!barred(v.pose, k.now())) views.push_back(&v);
  }
  std::ranges::stable_sort(views, {}, [&](const auto* v) { return (v->pose.p - here.p).norm(); });
  views.resize(std::min(views.size(), kManyLeftovers));
  const auto seconds = [&](const Pose& a, const Pose& b) {
    const double way_m = (straight(k.map(), a.p, b.p) ? 1.0 : kRoundabout) * (b.p - a.p).norm();
    return flight_s(way_m, b.p - a.p, a.yaw_rad, b.yaw_rad, k.limits());
  };
  const std::size_t n = views.size();
  route::OrderProblem problem;
  problem.travel_s.assign(n + 1, std::vector<double>(n + 1, 0));
  problem.budget_s = std::numeric_limits<double>::infinity();
  problem.gain.assign(n, 1);
  for (std::size_t i = 1; i <= n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double s = seconds(j == 0 ? here : views[j - 1]->pose, views[i - 1]->pose);
      problem.travel_s[i][j] = problem.travel_s[j][i] = s;
    }
  }
  const route::Order round = route::shortest_order(problem);
  if (round.visit.empty()) return std::nullopt;
  const Goal first = cluster_goal(k, *views[round.visit.front()]);
  const Pose& there = first.view.pose;
  const double back_s = roughly_s(there, meeting, there.yaw_rad, k.limits());
  if (first.view.arrive_s + back_s > budget_s) return std::nullopt;
  return first;
}

bool Exploration::choose(robot::Knowledge& k, double budget_s, const Vec3& meeting,
                         std::vector<mission::PlanningTime>& planning) {
  const robot::Stopwatch watch(planning, mission::PlanningStep::kExplore);
  std::erase_if(barred_, [&](const Barred& b) { return b.until <= k.now(); });
  std::vector<Goal> goals = candidates(k);
  if (goals.empty()) return false;
  if (std::ranges::all_of(goals, [](const Goal& g) { return g.view.value < kSmall; })) {
    if (const std::optional<Goal> g = leftover(k, budget_s, meeting)) goals = {*g};
  }
  if (goals.size() > kNearest) goals.resize(kNearest);
  while (goals.size() > 1 && goals.back().view.rate < kComparable * goals[0].view.rate)
    goals.pop_back();

  const std::size_t n = goals.size();
  route::OrderProblem problem;
  problem.budget_s = budget_s;
  problem.meeting = std::isfinite(budget_s);
  const std::size_t size = n + 1 + (problem.meeting ? 1 : 0);
  problem.travel_s.assign(size, std::vector<double>(size, 0));
  const auto seconds = [&](const Pose& a, const Vec3& b, double yaw_rad) {
    return roughly_s(a, b, yaw_rad, k.limits());
  };
  for (std::size_t i = 1; i <= n; ++i) {
    const Pose& from = goals[i - 1].view.pose;
    problem.travel_s[0][i] = problem.travel_s[i][0] = goals[i - 1].view.arrive_s;
    for (std::size_t j = 1; j <= n; ++j) {
      const Pose& to = goals[j - 1].view.pose;
      if (i != j) problem.travel_s[i][j] = seconds(from, to.p, to.yaw_rad);
    }
    if (problem.meeting) {
      problem.travel_s[i][n + 1] = problem.travel_s[n + 1][i] =
          seconds(from, meeting, from.yaw_rad);
    }
    problem.gain.push_back(goals[i - 1].view.value);
  }
  if (problem.meeting) {
    problem.travel_s[0][n + 1] = problem.travel_s[n + 1][0] =
        seconds(k.odometry().pose, meeting, k.odometry().pose.yaw_rad);
  }
  // Alg. 1 takes the longest way that still makes the meeting. That is only sensible when not
  // everything can be visited before it; otherwise the shortest way through all of it leaves more
  // time for what will be seen next.
  const route::Order all = route::shortest_order(problem);
  const route::Order order = all.length_s <= budget_s ? all : route::ff3e(problem, kNearest);
  if (order.visit.empty()) return false;
  goal_ = goals[order.visit.front()];
  log::debug("choose {}{} value {:.1f} rate {:.1f} (best {:.1f}) in {:.1f} s; known {:.0f}",
             goal_->cluster ? "cluster" : "place", goal_->view.look ? " look" : "",
             goal_->view.value, goal_->view.rate, goals[0].view.rate, goal_->view.arrive_s,
             known_m3(k));
  arrived_.reset();
  give_up_ = k.now() + Duration::from_s(kPatience * goal_->view.arrive_s + kSurfaceStay_s);
  return true;
}

std::optional<robot::Intent> Exploration::next(robot::Knowledge& k, const robot::Progress& progress,
                                               double budget_s, const Vec3& meeting,
                                               std::vector<mission::PlanningTime>& planning) {
  const SimTime now = k.now();
  take_told_looks(k);
  const bool news = scans_ + looks_ != settled_;
  if (news || progress.blocked_s > kBlocked_s) {
    if (news) {
      const robot::Stopwatch watch(planning, mission::PlanningStep::kFrontier);
      targets_.settle();
      settled_ = scans_ + looks_;
    }
    if (!worth_keeping(k, progress)) {
      goal_.reset();
      const bool due = scans_ != refreshed_scans_ && now >= refresh_again_;
      if (due) {
        refresh(k, false, planning);
        refresh_again_ = now + Duration::from_s(kRefresh_s);
      }
      bool found = choose(k, budget_s, meeting, planning);
      if (!found && due) {
        // Nothing near: look again with reachability known everywhere before saying so.
        refresh(k, true, planning);
        found = choose(k, budget_s, meeting, planning);
        entered_ = entered_ || known_m3(k) > 1.0;
        if (!found && entered_ && targets_.done() && ++empty_rounds_ >= 2) {
          (surveyed_ ? done_ : surveyed_) = true;
          empty_rounds_ = 0;
        }
      }
      if (found) empty_rounds_ = 0;
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
