#include "agent/strategy/slei3d_explorer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/log.h"
#include "common/robot/guardian.h"
#include "common/robot/stopwatch.h"
#include "common/route/predictor.h"

namespace muster::agent {
namespace {

constexpr double kVisitEvery_s = 5;  // S0.14: every 5 s
constexpr double kNegotiateAtMost_s = 25;
constexpr double kExchangeAtMost_s = 12;  // images still missing then go with the next contact
// With one that is at a stubborn area: so long without a result, then looking on for a while.
constexpr double kStay_s = 90, kLookOn_s = 150;
constexpr double kLeaveMargin_s = 4;
constexpr double kDetour = 1.4;
constexpr double kTellEvery_s = 5;
constexpr std::size_t kLooksTold = 30;  // at a time
constexpr double kRadioMargin_m = 1.5;  // nearer than the radio reaches: well in contact
constexpr double kCollect_s = 30, kSoonest_s = 50;
constexpr double kExploringApart_s = 150;  // between meetings with the station
constexpr double kThoroughApart_s = 300;   // little is found then
constexpr double kForesight = 3;           // times what was explored so far, at most
constexpr double kCornerInset_m = 0.6;
constexpr double kAtThePlace_m = 1.0;  // the station parks up to 3.5 m from it: still in range
constexpr double kMeetingHeight_m = 1.2;
// Without word of the station: at the start of a mission it speaks at once.
constexpr double kNoOrders_s = 20, kNoAgreement_s = 60;

}  // namespace

Slei3dExplorer::Slei3dExplorer(const mission::Mission& mission, RobotId self)
    : station_(mission.station()), agreement_(self, mission.station()) {}

void Slei3dExplorer::on_sightings(robot::Knowledge& k, const mission::Sightings& sightings) {
  k.keep_look(exploration_ ? exploration_->region() : kNoRegion, sightings);
  if (!exploration_) return;
  exploration_->on_look(k, sightings);
  fitter_.take(k, sightings, exploration_->region());
}

void Slei3dExplorer::on_scan(robot::Knowledge&, const mission::Scan& scan) {
  if (exploration_) exploration_->on_scan(scan);
}

Slei3dExplorer::Orders Slei3dExplorer::orders(const robot::Knowledge& k) const {
  const auto* assignment = k.plan(station_, mission::PlanKind::kAssignment);
  if (!assignment) return {};
  Orders o;
  for (const mission::Allocation& a : assignment->body.allocations) {
    if (a.robot == k.self()) o.known = true, o.region = a.region;
  }
  for (const mission::Allocation& a : assignment->body.allocations)
    o.thorough |= robot::says_surveyed(a) && a.region == o.region;
  return o;
}

void Slei3dExplorer::follow(robot::Knowledge& k, const Orders& o) {
  if (!o.known) return;
  thorough_ = o.thorough;
  if (o.region == kNoRegion) {
    released_ = true;
    exploration_.reset();
    agreement_.clear();
  } else if (!exploration_ || exploration_->region() != o.region) {
    released_ = false;
    exploration_.emplace(k, o.region);
    visit_.reset();
  }
}

bool Slei3dExplorer::explored() const {
  return exploration_ && (thorough_ ? exploration_->done() : exploration_->surveyed());
}

bool Slei3dExplorer::region_done(const robot::Knowledge& k) const {
  return explored() && !fitter_.in_doubt() && subgroup_.outstanding(k, exploration_->region()) == 0;
}

robot::Intent Slei3dExplorer::decide(robot::Knowledge& k, const robot::Progress& progress) {
  if (k.now() == k.started()) {
    agreement_.resume(k);
    fitter_.recall(k);
    told_looks_ = k.looks().size();
  }
  agreement_.be_told(k);
  follow(k, orders(k));
  const RegionId region = exploration_ ? exploration_->region() : kNoRegion;
  if (!released_) fitter_.review(k, explored());  // of what is said later nobody takes care
  subgroup_.update(k, region);
  if (exploration_ || released_)
    subgroup_.allocate(k, k.declared_complete() ? kNoRegion : region, exploring(), planning_);
  if (agreement_.update(k)) agreed_here_ = true;
  tell_progress(k);

  if (k.declared_complete() || released_) {
    if (auto intent = say_farewell(k, progress)) return *intent;
    return robot::go_home(
        k, k.declared_complete() ? "the mission is complete" : "no region is left to work on");
  }
  if (!exploration_) return await_orders(k);
  if (auto intent = meet_station(k, progress)) return *intent;
  if (auto intent = visit(k, progress)) return *intent;

  if (!exploration_->done()) {
    const mission::Rung rung = agreement_.next(k);
    const double budget_s = std::max(0.0, (rung.from - k.now()).s() - kLeaveMargin_s);
    if (auto intent = exploration_->next(k, progress, budget_s, rung.place, planning_))
      return *intent;
    robot::Intent look;
    look.activity = mission::Activity::kExploring;
    look.reason = "looking for what is left of region " + std::to_string(region.value);
    return look;
  }
  robot::Intent wait;
  wait.kind = robot::Intent::Kind::kGo;
  wait.goal.p = agreement_.next(k).place;
  wait.through_unknown = true;
  wait.tolerance_m = kAtThePlace_m;
  wait.activity = mission::Activity::kWaiting;
  wait.reason = subgroup_.outstanding(k, region) > 0 ? "explored; inspectors are still at work"
                                                     : "region done; waiting for the station";
  return wait;
}

// ---- the station

/// Since the station was heard, or since this start.
double Slei3dExplorer::unheard_s(const robot::Knowledge& k) const {
  return (k.now() - k.last_heard(station_).value_or(k.started())).s();
}

robot::Intent Slei3dExplorer::go_to(const robot::Knowledge& k, const mission::Rung& rung) const {
  robot::Intent intent;
  intent.kind = robot::Intent::Kind::kGo;
  intent.goal.p = rung.place;
  intent.goal.p.z() = std::max(intent.goal.p.z(), k.mission().hull.low().z() + kMeetingHeight_m);
  intent.through_unknown = true;
  intent.tolerance_m = kAtThePlace_m;
  intent.activity = mission::Activity::kMeeting;
  return intent;
}

robot::Intent Slei3dExplorer::await_orders(const robot::Knowledge& k) const {
  robot::Intent wait;
  if (unheard_s(k) > kNoOrders_s) wait = go_to(k, agreement_.next(k));
  wait.activity = mission::Activity::kWaiting;
  wait.reason = "waiting for the station's assignment";
  return wait;
}

std::optional<robot::Intent> Slei3dExplorer::meet_station(robot::Knowledge& k,
                                                          const robot::Progress&) {
  const bool first = agreement_.number() == 0;
  const mission::Rung rung = agreement_.next(k);
  if (negotiating_ &&
      (!k.in_contact(station_) || (k.now() - negotiating_since_).s() > kNegotiateAtMost_s)) {
    negotiating_ = false;
    leaving_ = false;
  }
  if (negotiating_) {
    robot::Intent intent = negotiate(k);
    if (negotiating_) return intent;
    return std::nullopt;
  }
  if (!leaving_ && (!first || unheard_s(k) > kNoAgreement_s)) leaving_ = time_to_leave(k, rung);
  // (A meeting that was missed is made up for wherever the two come across each other.)
  const bool meant = first || leaving_ || region_done(k) || agreement_.missed(k) > 0;
  if (meant && k.in_contact(station_)) {
    negotiating_ = true;
    negotiating_since_ = k.now();
    agreed_here_ = false;
    visit_.reset();
    return negotiate(k);
  }
  if (!leaving_) return std::nullopt;
  if (rung.from > k.now() + Duration::from_s(20) &&
      !time_to_leave(k, rung)) {  // this rung was missed: on with the work until the next
    leaving_ = false;
    return std::nullopt;
  }
  robot::Intent intent = go_to(k, rung);
  intent.reason = "to the meeting with the station at " +
                  std::to_string(static_cast<int>(rung.from.s())) + " s";
  return intent;
}

robot::Intent Slei3dExplorer::negotiate(robot::Knowledge& k) {
  robot::Intent hold;
  hold.activity = mission::Activity::kMeeting;
  hold.with = station_;
  hold.reason = "meeting the station";
  const double here_s = (k.now() - negotiating_since_).s();
  if (region_done(k)) {
    hold.reason = "region done: waiting for the next";
    return hold;  // the station answers with another region, or with none; `follow` takes it in
  }
  if (!agreed_here_ && !agreement_.pending())
    agreement_.propose(k, next_ladder(k), exploration_->region());
  if (agreed_here_ &&
      (k.exchanged(station_) || (here_s > kExchangeAtMost_s && k.talked(station_)))) {
    negotiating_ = false;
    leaving_ = false;
  }
  return hold;
}

bool Slei3dExplorer::time_to_leave(robot::Knowledge& k, const mission::Rung& rung) {
  const double left_s = (rung.from - k.now()).s();
  const double guess_s =
      nav::travel_time_s(kDetour * (rung.place - k.position()).norm(), k.limits()) + kLeaveMargin_s;
  if (left_s > 2.5 * guess_s + 10) return false;
  if (left_s <= guess_s) return true;
  if (k.now() < check_leave_) return false;
  check_leave_ = k.now() + Duration::from_s(2);
  const auto found = k.paths().find(k.position(), rung.place, 1.0);
  if (!found.path) return left_s <= 2 * guess_s;
  return left_s <= 1.15 * nav::travel_time_s(found.path->length_m(), k.limits()) + kLeaveMargin_s;
}

std::vector<mission::Rung> Slei3dExplorer::next_ladder(robot::Knowledge& k) {
  const robot::Stopwatch watch(planning_, mission::PlanningStep::kPredict);
  const RegionId region = exploration_->region();
  route::PredictorInput in;
  in.volume_m3 = exploration_->volume_m3(k);
  in.explored_m3 = exploration_->known_m3(k);
  in.elapsed_s = (k.now() - exploration_->since()).s();
  const robot::AreaCount areas = k.areas_in(region);
  in.features_found = areas.found;
  in.results_received = areas.inspected;
  double in_s = route::predict_remaining_s(in);
  if (in.elapsed_s < 10) {  // only just assigned: the way there, then the first slice
    in_s = nav::travel_time_s(kDetour * k.mission().boxes[region.value].distance(k.position()),
                              k.limits()) +
           route::kFirstSlice_s;
  }
  if (explored()) {
    // Nothing is left to predict by volume: the inspectors' work that is left, and its collection.
    in_s = std::clamp(subgroup_.remaining_s(k) + kCollect_s, kSoonest_s, in_s);
    if (k.now() < look_on_until_) in_s = std::max(in_s, kExploringApart_s);
  } else if (in.elapsed_s >= 10) {
    // Nearly done may go on for long, and every meeting costs a way there and back. What the first
    // minute promises of the rest is little more than a guess.
    const double apart_s = thorough_ ? kThoroughApart_s : kExploringApart_s;
    const double least_s = in.elapsed_s > route::kFirstSlice_s ? apart_s : 0;
    in_s = std::clamp(in_s, least_s, std::max(apart_s, kForesight * in.elapsed_s));
  }
  const Vec3 place = meeting_corner(k, in_s);
  const SimTime from = k.now() + Duration::from_s(in_s);
  const Duration window = Duration::from_s(3 * k.mission().meeting_tolerance_s);
  return {{place, from, from + window}, {place, from + window * 2, from + window * 3}};
}

/// The box corner that can be reached closest to the planned time (S0.8); of those that can be
/// reached in time, the station's nearest.
Vec3 Slei3dExplorer::meeting_corner(robot::Knowledge& k, double in_s) {
  Box inner = k.mission().boxes[exploration_->region().value];
  inner.size = (inner.size - Vec3::Constant(2 * kCornerInset_m)).cwiseMax(0.2);
  const Vec3 station = k.in_contact(station_) ? k.teammates().at(station_).beacon.pose.p
                                              : k.mission().standing.place;
  const auto corners = inner.corners();
  Vec3 best = corners[0];
  double best_cost = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i) {
    Vec3 c = corners[i];
    c.z() = std::clamp(k.mission().hull.low().z() + kMeetingHeight_m, k.mission().hull.low().z(),
                       inner.high().z());
    if (k.map().blocked(k.map().key(c))) continue;
    const double late_s =
        std::max(0.0, nav::travel_time_s(kDetour * (c - k.position()).norm(), k.limits()) - in_s);
    const double cost = 100 * late_s + (c - station).norm();
    if (cost < best_cost) best_cost = cost, best = c;
  }
  best.z() = k.mission().hull.low().z() + kMeetingHeight_m;
  return best;
}

void Slei3dExplorer::tell_progress(robot::Knowledge& k) {
  if (!exploration_) return;
  mission::RegionProgress p;
  p.region = exploration_->region();
  p.state = !explored()       ? mission::RegionState::kAssigned
            : !region_done(k) ? mission::RegionState::kExplored
            : thorough_       ? mission::RegionState::kDone
                              : mission::RegionState::kSurveyed;
  const robot::AreaCount areas = k.areas_in(p.region);
  p.areas_found = areas.found;
  p.areas_inspected = areas.inspected;
  const bool news = told_.regions.empty() || told_.regions[0].region != p.region ||
                    told_.regions[0].state != p.state;
  if (news || k.looks().size() >= told_looks_ + kLooksTold) tell_looks(k);
  const bool due = k.in_contact(station_) && (k.now() - told_at_).s() >= kTellEvery_s;
  if (!news && !due) return;
  p.explored_m3 = static_cast<float>(exploration_->known_m3(k));
  p.volume_m3 = static_cast<float>(exploration_->volume_m3(k));
  told_ = {};
  told_.kind = mission::StatusKind::kHealth;
  told_.robot = k.self();
  told_.battery = k.battery().charge;
  told_.regions = {p};
  told_at_ = k.now();
  k.publish(store::RecordClass::kStatus, robot::kHealthKey, told_);
}

/// Whoever goes on with this region need not look again; nor has this robot, should it lose its
/// journal: it is said for good.
void Slei3dExplorer::tell_looks(robot::Knowledge& k) {
  mission::Status status;
  status.kind = mission::StatusKind::kLooks;
  status.robot = k.self();
  for (; told_looks_ < k.looks().size(); ++told_looks_) {
    const auto& [explored, look] = k.looks()[told_looks_];
    if (explored != kNoRegion) status.looks.push_back(look.sensor);
  }
  if (!status.looks.empty())
    k.publish(store::RecordClass::kRequest, k.store().new_key(store::RecordClass::kRequest),
              status);
}

// ---- the inspectors

std::optional<robot::Intent> Slei3dExplorer::visit(robot::Knowledge& k,
                                                   const robot::Progress& progress) {
  const double tolerance_s = k.mission().meeting_tolerance_s;
  if (visit_) {
    const RobotId mate = visit_->mate;
    const bool contact = k.in_contact(mate);
    const double apart_m =
        contact ? (k.teammates().at(mate).beacon.pose.p - k.position()).norm() : 1e9;
    if (contact && !visit_contact_since_) visit_contact_since_ = k.now();
    if (contact && subgroup_.settled(k, mate)) {
      // After exploring, one that is still at work is stayed with while there is nobody else.
      const auto next = subgroup_.next_visit(k, exploring());
      visit_.reset();
      if (next && next->mate == mate && !exploring()) {
        if (stayed_in_vain(k)) {
          log::info("nothing comes of staying with inspector {}: looking on", mate.value);
          consider_visit_ = look_on_until_ = k.now() + Duration::from_s(kLookOn_s);
          return std::nullopt;
        }
        visit_ = next;
        robot::Intent stay;
        stay.activity = mission::Activity::kWaiting;
        stay.with = mate;
        stay.reason = "staying with inspector " + std::to_string(mate.value);
        return stay;
      }
      staying_since_.reset();
      consider_visit_ = k.now();
    } else if (contact && visit_contact_since_ &&
               (k.now() - *visit_contact_since_).s() > kExchangeAtMost_s && k.talked(mate))
      visit_.reset();
    else if (contact && apart_m < k.mission().radio.range_m - kRadioMargin_m) {
      robot::Intent talk;
      talk.activity = mission::Activity::kMeeting;
      talk.with = mate;
      talk.reason = "meeting inspector " + std::to_string(mate.value);
      return talk;
    } else {
      const bool there =
          progress.state == robot::Progress::State::kArrived || progress.blocked_s > tolerance_s;
      if (!contact && there && k.now() >= visit_->at) {
        if (!visit_waiting_since_) visit_waiting_since_ = k.now();
        if ((k.now() - *visit_waiting_since_).s() > tolerance_s) {
          subgroup_.missed(k, mate, progress.state == robot::Progress::State::kArrived);
          visit_.reset();
        }
      }
    }
  }
  if (!visit_) {
    if (k.now() < consider_visit_) return std::nullopt;
    visit_ = subgroup_.next_visit(k, exploring());
    consider_visit_ = k.now() + Duration::from_s(exploring() ? kVisitEvery_s : 1.0);
    visit_waiting_since_.reset();
    visit_contact_since_.reset();
    if (!visit_) return std::nullopt;
  }
  robot::Intent intent;
  intent.kind = robot::Intent::Kind::kGo;
  intent.goal.p =
      k.in_contact(visit_->mate) ? k.teammates().at(visit_->mate).beacon.pose.p : visit_->place;
  intent.tolerance_m = 2.0;
  intent.through_unknown = true;
  intent.with = visit_->mate;
  intent.activity = mission::Activity::kTravelling;
  intent.reason = "to inspector " + std::to_string(visit_->mate.value);
  return intent;
}

/// For long, without a result, while there is something left to look at.
bool Slei3dExplorer::stayed_in_vain(const robot::Knowledge& k) {
  if (!exploration_ || exploration_->done()) return false;
  const std::size_t left = subgroup_.outstanding(k, exploration_->region());
  if (!staying_since_ || left != left_when_staying_) {
    staying_since_ = k.now();
    left_when_staying_ = left;
  }
  if ((k.now() - *staying_since_).s() < kStay_s) return false;
  staying_since_.reset();
  return true;
}

/// Before going home: the inspectors hear that it is over.
std::optional<robot::Intent> Slei3dExplorer::say_farewell(robot::Knowledge& k,
                                                          const robot::Progress& progress) {
  if (subgroup_.all_informed()) return std::nullopt;
  return visit(k, progress);
}

}  // namespace muster::agent
