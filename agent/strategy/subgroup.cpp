#include "agent/strategy/subgroup.h"

#include <algorithm>

#include "agent/strategy/slei3d_inspector.h"
#include "common/robot/stopwatch.h"
#include "common/route/allocate.h"

namespace muster::agent {
namespace {

constexpr double kIdleSlack_s = 3;
constexpr double kPerArea_s = 11;  // of an inspector: the way, the look, now and then another one
constexpr double kTalk_s = 4;
constexpr double kWorth = 1.0;            // an explorer's second against an inspector's
constexpr std::size_t kAlwaysWorth = 14;  // areas to hand over
constexpr std::size_t kLoad = 12;         // areas that one visit is counted to hand over, at most
constexpr double kApartExploring_s = 45, kApart_s = 12;  // a visit's price, in the sharing of areas
constexpr double kForget_s = 3;
constexpr double kAgainAfterMiss_s = 30;
constexpr int kMissesUntilLost = 2, kNoWayUntilLost = 5;
constexpr double kDetour = 1.3;

}  // namespace

bool Subgroup::mine(const robot::Knowledge& k, const mission::AreaRef& ref, RegionId region) const {
  return k.areas().at(ref).area.region == region || ref.author == k.self();
}

void Subgroup::update(robot::Knowledge& k, RegionId region) {
  for (const RobotId station : k.mission().with_role(mission::Role::kStation)) {
    const auto* assignment = k.plan(station, mission::PlanKind::kAssignment);
    if (!assignment) continue;
    for (const mission::Allocation& a : assignment->body.allocations) {
      if (!k.mission().has(a.robot) || k.mission().robot(a.robot).role != mission::Role::kInspector)
        continue;
      if (a.leader == k.self())
        mates_.try_emplace(a.robot, Mate{a.robot, k.now(), k.now(), 0, {}});
      else
        mates_.erase(a.robot);
    }
  }
  for (auto& [id, mate] : mates_) {
    if (!k.in_contact(id)) continue;
    mate.seen = k.now();
    mate.missed = mate.out_of_reach = mate.in_vain = 0;
    mate.not_before = k.now();
    mate.lost = false;
    if (!k.knows(id, store::RecordClass::kPlan, robot::plan_key(mission::PlanKind::kAllocation)))
      continue;
    mate.told = published_region_;
    for (const auto& [ref, to] : given_) {
      if (to == id) heard_.insert(ref);
    }
  }
  // Done, or given to somebody who is lost or went before it could hear: not given any more.
  std::erase_if(given_, [&](const auto& g) {
    const auto mate = mates_.find(g.second);
    return k.inspected(g.first) || mate == mates_.end() || mate->second.lost ||
           (!heard_.contains(g.first) && (k.now() - mate->second.seen).s() > kForget_s);
  });
  std::erase_if(heard_, [&](const mission::AreaRef& ref) { return !given_.contains(ref); });
  std::erase_if(order_, [&](const mission::AreaRef& ref) { return !given_.contains(ref); });
  open_.clear();
  if (region == kNoRegion) return;
  for (const auto& [ref, known] : k.areas()) {
    if (!given_.contains(ref) && !k.inspected(ref) && mine(k, ref, region)) open_.push_back(ref);
  }
}

SimTime Subgroup::free_at(const robot::Knowledge& k, RobotId id) const {
  const auto* route = k.plan(id, mission::PlanKind::kRoute);
  if (!route || route->body.steps.empty()) return k.now();
  return route->body.steps.back().at.t;
}

Vec3 Subgroup::expected_place(const robot::Knowledge& k, RobotId id, SimTime t) const {
  if (k.in_contact(id) && free_at(k, id) <= t) return k.teammates().at(id).beacon.pose.p;
  const auto mate = mates_.find(id);
  const auto* route = k.plan(id, mission::PlanKind::kRoute);
  if (mate != mates_.end() && (t - mate->second.seen).s() > kUnheard_s &&
      free_at(k, id) + Duration::from_s(kPerArea_s) < t)
    return k.mission().robot(id).start.p;
  if (!route || route->body.steps.empty()) {
    return published_region_ == kNoRegion ? k.mission().robot(id).start.p
                                          : gathering_place(k.mission(), published_region_, id);
  }
  const auto& steps = route->body.steps;
  for (const mission::PlanStep& s : steps) {
    if (s.at.t + Duration::from_s(static_cast<double>(s.duration_s)) >= t) return s.at.pose.p;
  }
  return steps.back().at.pose.p;
}

void Subgroup::allocate(robot::Knowledge& k, RegionId region, bool exploring,
                        std::vector<mission::PlanningTime>& planning) {
  std::vector<RobotId> crew;
  for (const auto& [id, mate] : mates_) {
    if (!mate.lost) crew.push_back(id);
  }
  const bool someone =
      std::any_of(crew.begin(), crew.end(), [&](RobotId id) { return k.in_contact(id); });
  bool changed = !published_ || published_region_ != region || published_mates_ != crew;
  if (someone && !open_.empty()) {
    const robot::Stopwatch watch(planning, mission::PlanningStep::kAllocate);
    route::AllocationProblem problem;
    const auto position = [&](std::size_t a) -> const Vec3& {
      return k.areas().at(open_[a]).area.position;
    };
    const auto seconds = [&](const Vec3& a, const Vec3& b) {
      return nav::travel_time_s(kDetour * (a - b).norm(), k.limits());
    };
    for (const RobotId id : crew) {
      const SimTime free = std::max(free_at(k, id), k.now());
      const double apart_s = k.in_contact(id)
                                 ? 0
                                 : (exploring ? kApartExploring_s : kApart_s) +
                                       seconds(k.position(), expected_place(k, id, free));
      problem.free_at_s.push_back((free - k.now()).s() + apart_s);
      const Vec3 from = expected_place(k, id, free);
      auto& first = problem.first_s.emplace_back();
      for (std::size_t a = 0; a < open_.size(); ++a) first.push_back(seconds(from, position(a)));
    }
    for (std::size_t a = 0; a < open_.size(); ++a) {
      auto& row = problem.between_s.emplace_back();
      for (std::size_t b = 0; b < open_.size(); ++b)
        row.push_back(seconds(position(a), position(b)));
      problem.service_s.push_back(k.mission().inspect.hold_s + 1.0);
    }
    const auto shares = route::allocate(problem);
    for (std::size_t i = 0; i < crew.size(); ++i) {
      if (!k.in_contact(crew[i])) continue;  // the others get theirs when they are met
      for (const std::uint32_t a : shares[i]) {
        given_[open_[a]] = crew[i];
        order_.push_back(open_[a]);
        changed = true;
      }
    }
    std::erase_if(open_, [&](const mission::AreaRef& ref) { return given_.contains(ref); });
  }
  if (changed) publish(k, region);
}

void Subgroup::publish(robot::Knowledge& k, RegionId region) {
  mission::Plan plan;
  plan.kind = mission::PlanKind::kAllocation;
  published_mates_.clear();
  for (const auto& [id, mate] : mates_) {
    if (mate.lost) continue;
    published_mates_.push_back(id);
    plan.allocations.push_back({id, k.self(), region, {}});
  }
  for (const mission::AreaRef& ref : order_)
    plan.allocations.push_back({given_.at(ref), k.self(), region, ref});
  published_region_ = region;
  published_ = true;
  k.publish(store::RecordClass::kPlan, robot::plan_key(mission::PlanKind::kAllocation), plan);
}

bool Subgroup::settled(const robot::Knowledge& k, RobotId id) const {
  return k.knows(id, store::RecordClass::kPlan, robot::plan_key(mission::PlanKind::kAllocation)) &&
         k.talked(id) && std::none_of(k.results().begin(), k.results().end(), [&](const auto& r) {
           return r.second.by == id && !r.second.complete();
         });
}

bool Subgroup::informed(RobotId id) const {
  return mates_.at(id).told == published_region_ &&
         std::all_of(given_.begin(), given_.end(),
                     [&](const auto& g) { return g.second != id || heard_.contains(g.first); });
}

bool Subgroup::all_informed() const {
  return std::all_of(mates_.begin(), mates_.end(),
                     [&](const auto& m) { return m.second.lost || informed(m.first); });
}

std::size_t Subgroup::outstanding(const robot::Knowledge& k, RegionId region) const {
  std::size_t n = 0;
  for (const auto& [ref, known] : k.areas()) {
    n += mine(k, ref, region) && !k.result_complete(ref) ? 1 : 0;
  }
  return n;
}

std::optional<Subgroup::Visit> Subgroup::next_visit(const robot::Knowledge& k,
                                                    bool exploring) const {
  std::optional<Visit> best;
  double best_s = 1e18;
  for (const auto& [id, mate] : mates_) {
    if (mate.lost || k.now() < mate.not_before) continue;
    std::size_t holds = 0;
    for (const auto& [ref, to] : given_) holds += to == id ? 1 : 0;
    for (const auto& [ref, result] : k.results())
      holds += result.by == id && !result.complete() ? 1 : 0;
    const SimTime free = std::max(free_at(k, id), k.now());
    const Vec3 place = expected_place(k, id, free);
    const double way_s = nav::travel_time_s(kDetour * (place - k.position()).norm(), k.limits());
    const SimTime arrive = k.now() + Duration::from_s(way_s);
    const bool idle = free <= arrive + Duration::from_s(kIdleSlack_s);
    bool wanted = false;
    if (exploring) {
      const double work_s = kPerArea_s * static_cast<double>(std::min(open_.size(), kLoad));
      wanted = idle && (work_s > kWorth * (2 * way_s + kTalk_s) || open_.size() >= kAlwaysWorth) &&
               !open_.empty();
    } else {
      wanted = holds > 0 || !informed(id) || (!open_.empty() && idle);
    }
    if (!wanted) continue;
    // When it is free it is done with everything: come then, or as soon as one can. One that is
    // here and still at work is waited for only while there is nobody else to go to.
    const SimTime at = std::max(arrive, free);
    const double cost_s = (at - k.now()).s() + (settled(k, id) ? 60 : 0);
    if (cost_s < best_s) {
      best_s = cost_s;
      best = Visit{id, place, at};
    }
  }
  if (!best && !exploring && !open_.empty()) return search_for_lost(k);
  return best;
}

/// One that was not where it was expected may wait where its region begins or where it started:
/// it did not hear that it changed groups, say.
std::optional<Subgroup::Visit> Subgroup::search_for_lost(const robot::Knowledge& k) const {
  const Mate* next = nullptr;
  for (const auto& [id, mate] : mates_) {
    if (!mate.lost || k.now() < mate.not_before) continue;
    if (!next || mate.in_vain < next->in_vain) next = &mate;
  }
  if (!next) return std::nullopt;
  const Vec3 places[] = {expected_place(k, next->id, k.now()),
                         gathering_place(k.mission(), published_region_, next->id),
                         k.mission().robot(next->id).start.p};
  return Visit{next->id, places[next->in_vain % std::ssize(places)], k.now()};
}

double Subgroup::remaining_s(const robot::Knowledge& k) const {
  double last_s = 0;
  std::size_t crew = 0;
  for (const auto& [id, mate] : mates_) {
    if (mate.lost) continue;
    ++crew;
    const SimTime free = std::max(free_at(k, id), k.now());
    const Vec3 place = expected_place(k, id, free);
    last_s = std::max(last_s,
                      (free - k.now()).s() +
                          nav::travel_time_s(kDetour * (place - k.position()).norm(), k.limits()));
  }
  return last_s + kPerArea_s * static_cast<double>(open_.size()) /
                      static_cast<double>(std::max<std::size_t>(crew, 1));
}

void Subgroup::missed(robot::Knowledge& k, RobotId id, bool arrived) {
  Mate& mate = mates_.at(id);
  mate.not_before = k.now() + Duration::from_s((1 + mate.in_vain) * kAgainAfterMiss_s);
  ++mate.in_vain;
  ++(arrived ? mate.missed : mate.out_of_reach);
  if (mate.lost || (mate.missed < kMissesUntilLost && mate.out_of_reach < kNoWayUntilLost)) return;
  mate.lost = true;
  mission::Status lost;
  lost.kind = mission::StatusKind::kLost;
  lost.robot = id;
  k.publish(store::RecordClass::kRequest, robot::lost_key(id), lost);
}

}  // namespace muster::agent
