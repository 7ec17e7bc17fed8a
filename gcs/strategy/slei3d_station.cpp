#include "gcs/strategy/slei3d_station.h"

#include <algorithm>
#include <cmath>

#include "common/radio/path_loss.h"
#include "common/robot/guardian.h"
#include "common/robot/stopwatch.h"
#include "common/route/tour.h"

namespace muster::gcs {
namespace {

constexpr double kDetour = 1.4;
constexpr double kTourEvery_s = 2;
constexpr double kMeeting_s = 2;
constexpr double kLateWeight = 10;  // an explorer and its group wait, against the station alone
constexpr double kParkEvery_s = 3;
constexpr double kRadioMargin_m = 1.5;  // parked so much closer than the radio reaches
constexpr double kNotTooClose_m = 1.2;
constexpr double kUnheard_m = 50;    // of way, that being heard is worth
constexpr double kBeginning_s = 10;  // of a mission: who starts later had started before
constexpr int kRungsUntilLost = 4;   // two agreed rungs and two standing ones

}  // namespace

Slei3dStation::Slei3dStation(const mission::Mission& mission, RobotId self) : regions_(mission) {
  for (const RobotId id : mission.with_role(mission::Role::kExplorer))
    agreements_.emplace(id, robot::Agreement(self, id));
}

robot::Intent Slei3dStation::decide(robot::Knowledge& k, const robot::Progress&) {
  if (!assigned_) assigned_ = begin(k);
  meet(k);
  if (assigned_) count_missed(k);
  if (!declared_ && regions_.all_done()) declare(k);

  robot::Intent intent;
  intent.kind = robot::Intent::Kind::kGo;
  intent.through_unknown = true;
  if (declared_) return robot::go_home(k, "the mission is complete");
  if (k.now() >= tour_again_ || (partner_ && !agreements_.contains(*partner_))) {
    partner_ = next_partner(k);
    tour_again_ = k.now() + Duration::from_s(kTourEvery_s);
  }
  if (!partner_) {
    intent.goal = k.config().start;
    intent.tolerance_m = 0.5;
    intent.activity = mission::Activity::kWaiting;
    intent.reason = "no meeting is due";
    return intent;
  }
  const mission::Rung rung = agreements_.at(*partner_).next(k);
  if (k.in_contact(*partner_)) {
    intent.with = *partner_;
    intent.kind = robot::Intent::Kind::kHover;
    intent.activity = mission::Activity::kMeeting;
    intent.reason = "meeting explorer " + std::to_string(partner_->value);
    return intent;
  }
  intent.goal.p = parking_for(k, rung.place);
  intent.tolerance_m = 0.6;
  intent.activity = (intent.goal.p - k.position()).norm() < 0.8 ? mission::Activity::kWaiting
                                                                : mission::Activity::kTravelling;
  intent.reason = "to the meeting with explorer " + std::to_string(partner_->value) + " at " +
                  std::to_string(static_cast<int>(rung.from.s())) + " s";
  return intent;
}

/// Takes up what an earlier start left, or what somebody else knows of it; at the start of a
/// mission there is nothing. False: nobody has told us yet.
bool Slei3dStation::begin(robot::Knowledge& k) {
  if (k.now() == k.started()) {
    for (auto& [id, agreement] : agreements_) agreement.resume(k);
  }
  const bool told =
      std::ranges::any_of(agreements_, [&](const auto& a) { return k.talked(a.first); });
  declared_ = k.declared_complete();
  if (regions_.resume(k)) return true;
  if (k.started() > SimTime::from_s(kBeginning_s) && !told) return false;
  regions_.assign_all(k);
  return true;
}

void Slei3dStation::meet(robot::Knowledge& k) {
  for (auto& [id, agreement] : agreements_) {
    if (!k.in_contact(id)) continue;
    if (regions_.report(k, id)) tour_again_ = k.now();
    if (regions_.groups().at(id).released) agreement.clear();
    if (agreement.update(k)) tour_again_ = k.now();
  }
}

void Slei3dStation::count_missed(robot::Knowledge& k) {
  for (const auto& [id, agreement] : agreements_) {
    const auto& group = regions_.groups().at(id);
    if (group.released || group.lost || k.in_contact(id)) continue;
    if (agreement.missed(k) >= kRungsUntilLost) regions_.lost(k, id);
  }
}

/// The first of the tour over all pending meetings (S0.10).
std::optional<RobotId> Slei3dStation::next_partner(robot::Knowledge& k) {
  const robot::Stopwatch watch(planning_, mission::PlanningStep::kTour);
  std::vector<RobotId> ids;
  route::TourProblem problem;
  std::vector<Vec3> places{k.position()};
  problem.now_s = k.now().s();
  problem.wait_weight = 1;
  for (const auto& [id, agreement] : agreements_) {
    const auto& group = regions_.groups().at(id);
    if (group.released) continue;
    const mission::Rung rung = agreement.next(k);
    if (group.lost && rung.from > k.now() + Duration::from_s(60))
      continue;  // maybe it comes to the standing rung after all
    ids.push_back(id);
    places.push_back(rung.place);
    problem.stops.push_back({rung.from.s(), rung.until.s(), kMeeting_s, kLateWeight});
  }
  if (ids.empty()) return std::nullopt;
  for (const Vec3& a : places) {
    auto& row = problem.travel_s.emplace_back();
    for (const Vec3& b : places)
      row.push_back(nav::travel_time_s(kDetour * (a - b).norm(), k.limits()));
  }
  return ids[route::plan_tour(problem)->order.front()];  // windows are soft: there is a tour
}

/// A drivable spot from which the meeting place is well heard (the radio's forecast, by what is
/// known of walls), as near as it can be.
Vec3 Slei3dStation::parking_for(robot::Knowledge& k, const Vec3& place) {
  if (parking_ && (parking_->first - place).norm() < 0.1 && k.now() < parking_again_)
    return parking_->second;
  parking_again_ = k.now() + Duration::from_s(kParkEvery_s);
  const double ride_m = k.config().start.p.z();
  Vec3 fallback = place;
  fallback.z() = ride_m;
  k.paths().flood(k.position());
  const double range_m = k.mission().radio.range_m - kRadioMargin_m;
  Vec3 best = fallback;
  double best_cost = 1e18;
  for (int ring = 0; kNotTooClose_m + 0.4 * ring <= range_m; ++ring) {
    const double r = kNotTooClose_m + 0.4 * ring;
    for (int i = 0; i < 16; ++i) {
      const double a = i * std::numbers::pi / 8;
      const Vec3 p(place.x() + r * std::cos(a), place.y() + r * std::sin(a), ride_m);
      if (!k.map().traversable(p) || !k.paths().reached(p)) continue;
      const int walls = k.map().line_of_sight(p, place, true) ? 0 : 1;
      const double heard = radio::forecast(k.mission().radio, (p - place).norm(), walls);
      const double cost = k.paths().flood_distance(p) + kUnheard_m * (1 - heard);
      if (cost < best_cost) best_cost = cost, best = p;
    }
  }
  parking_ = {place, best};
  return best;
}

void Slei3dStation::declare(robot::Knowledge& k) {
  if (!std::ranges::all_of(k.areas(), [&](const auto& a) { return k.result_complete(a.first); }))
    return;
  declared_ = true;
  mission::Status status;
  status.kind = mission::StatusKind::kComplete;
  status.robot = kNoRobot;
  status.note = "all regions explored, all areas inspected";
  k.publish(store::RecordClass::kRequest, robot::kCompleteKey, status);
}

}  // namespace muster::gcs
