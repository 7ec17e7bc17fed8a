#include "common/robot/guardian.h"

#include <algorithm>
#include <utility>

namespace muster::robot {
namespace {

/// Who has heard nobody yet has been alone since it started, not since the mission did.
SimTime last_heard_anyone(const Knowledge& k) {
  if (k.teammates().empty()) return k.started();
  SimTime last;
  for (const auto& [id, mate] : k.teammates()) last = std::max(last, mate.heard);
  return last;
}

constexpr double kLongestTurn_s = 30, kRound_s = 300;

// Telling others that they are called home: how far from here, for how long altogether, and how
// much later than planned an inspector may be where its route ends.
constexpr double kTellWithin_m = 30, kTellFor_s = 180, kTellStay_s = 12, kTellSpeed_mps = 0.7;

bool low_battery(const Knowledge& k) {
  return k.config().vehicle.discharge_mah_per_s > 0 &&
         k.battery().charge < k.mission().battery_reserve && !k.battery().charging;
}

/// Silent robots go home one after the other. Two that fly the same speed on courses less than 90°
/// apart are never in each other's camera, and all that lost each other at once would set out at
/// once, for the same place.
bool my_turn(const Knowledge& k) {
  const auto& fleet = k.mission().fleet;
  const auto count = static_cast<double>(fleet.size());
  const double turn_s = std::min(kLongestTurn_s, kRound_s / count);
  const auto rank = std::count_if(fleet.begin(), fleet.end(), [&](const auto& r) {
    return std::pair(r.role, r.id) < std::pair(k.config().role, k.self());
  });
  return static_cast<std::int64_t>(k.now().s() / turn_s) %
             static_cast<std::int64_t>(fleet.size()) ==
         rank;
}

/// Whom this robot leads, as far as it tells them: the station explorers, an explorer inspectors.
bool leads(const Knowledge& k, mission::Role role) {
  return (k.config().role == mission::Role::kStation && role == mission::Role::kExplorer) ||
         (k.config().role == mission::Role::kExplorer && role == mission::Role::kInspector);
}

}  // namespace

Intent go_home(const Knowledge& k, std::string reason, bool land) {
  Intent intent;
  intent.kind = land ? Intent::Kind::kLand : Intent::Kind::kGo;
  intent.goal = k.config().start;
  intent.through_unknown = true;
  intent.activity = mission::Activity::kReturning;
  if (land && k.odometry().state == mission::VehicleState::kLanded)
    intent.activity = mission::Activity::kLanded;
  intent.reason = std::move(reason);
  return intent;
}

/// Where `mate` may be found soonest: an inspector on its route, or, `late`, where that ends;
/// an explorer where it was flying when it was last heard.
std::optional<mission::TimedPose> Guardian::expected(const Knowledge& k, const Teammate& mate,
                                                     bool late) {
  if (mate.beacon.role == mission::Role::kExplorer) {
    mission::TimedPose last{mate.heard, mate.beacon.pose};
    if (!mate.beacon.trajectory.empty()) last = mate.beacon.trajectory.back();
    last.pose.p.z() = k.position().z();
    return last;
  }
  const auto* route = k.plan(mate.beacon.envelope.src, mission::PlanKind::kRoute);
  if (!route || route->body.steps.empty()) return std::nullopt;
  for (const mission::PlanStep& step : route->body.steps) {
    const double way_m = (step.at.pose.p - k.position()).norm();
    if (!late && step.at.t >= k.now() + Duration::from_s(way_m / kTellSpeed_mps)) return step.at;
  }
  return route->body.steps.back().at;
}

/// The nearest place where somebody may be who has not heard.
std::optional<Guardian::Errand> Guardian::next_errand(const Knowledge& k) const {
  std::optional<Errand> best;
  double best_m = kTellWithin_m;
  for (const auto& [id, mate] : k.teammates()) {
    if (told_.contains(id) || !leads(k, mate.beacon.role)) continue;
    const auto last = expected(k, mate, true);
    const auto place = in_vain_.contains(id) ? last : expected(k, mate, false);
    if (!place) continue;
    const double way_m = (place->pose.p - k.position()).norm();
    if (way_m >= best_m) continue;
    best_m = way_m;
    best = {id, place->pose.p,
            std::max(place->t, k.now() + Duration::from_s(way_m / kTellSpeed_mps)) +
                Duration::from_s(kTellStay_s),
            place->pose.p == last->pose.p};
  }
  return best;
}

std::optional<Intent> Guardian::tell_others(const Knowledge& k) {
  if (!called_home_) called_home_ = k.now();
  if (k.config().role == mission::Role::kInspector || low_battery(k) ||
      (k.now() - *called_home_).s() > kTellFor_s)
    return std::nullopt;
  for (const auto& [id, mate] : k.teammates()) {
    using mission::Activity;
    const Activity doing = mate.beacon.activity;
    const bool goes_home =
        doing == Activity::kReturning || doing == Activity::kLanding || doing == Activity::kLanded;
    if (k.talked(id) || (goes_home && mate.heard >= *called_home_)) told_.insert(id);
  }
  if (errand_ && k.now() > errand_->until) {
    (errand_->last ? told_ : in_vain_).insert(errand_->mate);
    errand_.reset();
  }
  if (errand_ && told_.contains(errand_->mate)) errand_.reset();
  if (!errand_) errand_ = next_errand(k);
  if (!errand_) return std::nullopt;
  Intent intent;
  intent.kind = Intent::Kind::kGo;
  intent.goal.p = errand_->place;
  intent.tolerance_m = 1.5;
  intent.through_unknown = true;
  intent.with = errand_->mate;
  intent.activity = mission::Activity::kReturning;
  intent.reason = "called home: tells robot " + std::to_string(errand_->mate.value) + " on the way";
  return intent;
}

std::optional<Intent> Guardian::overrule(const Knowledge& k) {
  using mission::RequestVerb;
  if (const mission::Status* request = k.request()) {
    if (request->request != RequestVerb::kLand) land_here_.reset();
    const bool home =
        request->request == RequestVerb::kReturn || request->request == RequestVerb::kAbort;
    if (!home) called_home_.reset(), errand_.reset(), told_.clear(), in_vain_.clear();
    if (home && request->robot == kNoRobot) {
      if (auto errand = tell_others(k)) return errand;
    }
    switch (request->request) {
      case RequestVerb::kHold: {
        Intent hold;
        hold.activity = mission::Activity::kHolding;
        hold.reason = "the operator asked to hold";
        return hold;
      }
      case RequestVerb::kReturn:
        return go_home(k, "the operator asked to return", false);
      case RequestVerb::kAbort:
        return go_home(k, "the operator aborted the mission");
      case RequestVerb::kLand: {
        if (!land_here_) land_here_ = k.position();
        Intent land;
        land.kind = Intent::Kind::kLand;
        land.goal.p = *land_here_;
        land.activity = mission::Activity::kLanding;
        land.reason = "the operator asked to land";
        return land;
      }
      case RequestVerb::kNone:
      case RequestVerb::kResume:
        break;
    }
  }
  if (low_battery(k)) {
    return go_home(k, "battery below its reserve");
  }
  if ((k.now() - last_heard_anyone(k)).s() <= k.mission().lost_contact_s) {
    going_silently_ = false;
    return std::nullopt;
  }
  going_silently_ = going_silently_ || my_turn(k);
  if (going_silently_) return go_home(k, "nobody heard for too long");
  Intent wait;
  wait.activity = mission::Activity::kWaiting;
  wait.reason = "nobody heard for too long: waiting for its turn to go home";
  return wait;
}

}  // namespace muster::robot
