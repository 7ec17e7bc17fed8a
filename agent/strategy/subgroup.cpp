#include "agent/strategy/subgroup.h"

#include <algorithm>

#include "agent/strategy/slei3d_inspector.h"
#include "common/robot/stopwatch.h"
#include "common/route/allocate.h"

namespace muster::agent {
namespace {

constexpr double kIdleSlack_s = 3;
constexpr std::size_t kWorthAVisit = 4;  // areas to hand over before exploring is interrupted
constexpr double kIdleLong_s = 25;
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
        mates_.try_emplace(a.robot, Mate{a.robot, k.now(), k.now()});
      else
        mates_.erase(a.robot);
    }
  }
  for (auto& [id, mate] : mates_) {
    if (!k.in_contact(id)) continue;
    mate.seen = k.now();
    mate.missed = 0;
    mate.lost = false;
    at_gathering_[id] = false;
  }
  // Done, or given to somebody who is lost: not given any more.
  std::erase_if(given_, [&](const auto& g) {
    const auto mate = mates_.find(g.second);
    return k.inspected(g.first) || mate == mates_.end() || mate->second.lost;
  });
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
  const auto* route = k.plan(id, mission::PlanKind::kRoute);
  const auto gathering = at_gathering_.find(id);
  if (k.in_contact(id) && free_at(k, id) <= t) return k.teammates().at(id).beacon.pose.p;
  const bool away = gathering != at_gathering_.end() && gathering->second;
  if (!route || route->body.steps.empty() || away) {
    return published_region_ == kNoRegion ? k.mission().robot(id).start.p
                                          : gathering_place(k.mission(), published_region_, id);
  }
  const auto& steps = route->body.steps;
  if (t > steps.back().at.t + Duration::from_s(kWaitHere_s) && published_region_ != kNoRegion) {
    return gathering_place(k.mission(), published_region_, id);
  }
  for (const mission::PlanStep& s : steps) {
    if (s.at.t + Duration::from_s(static_cast<double>(s.duration_s)) >= t) return s.at.pose.p;
  }
  return steps.back().at.pose.p;
}

void Subgroup::allocate(robot::Knowledge& k, RegionId region,
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
      problem.free_at_s.push_back((free - k.now()).s());
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

bool Subgroup::all_informed(const robot::Knowledge& k) const {
  return std::all_of(mates_.begin(), mates_.end(), [&](const auto& m) {
    return m.second.lost || k.knows(m.first, store::RecordClass::kPlan,
                                    robot::plan_key(mission::PlanKind::kAllocation));
  });
}

std::size_t Subgroup::outstanding(const robot::Knowledge& k, RegionId region) const {
  std::size_t n = 0;
  for (const auto& [ref, known] : k.areas()) {
    if (!mine(k, ref, region)) continue;
    const auto result = k.results().find(ref);
    n += result == k.results().end() || !result->second.complete() ? 1 : 0;
  }
  return n;
}

std::optional<Subgroup::Visit> Subgroup::next_visit(const robot::Knowledge& k,
                                                    bool exploring) const {
  std::optional<Visit> best;
  double best_s = 1e18;
  for (const auto& [id, mate] : mates_) {
    if (mate.lost) continue;
    std::size_t holds = 0;
    for (const auto& [ref, to] : given_) holds += to == id ? 1 : 0;
    for (const auto& [ref, result] : k.results())
      holds += result.by == id && !result.complete() ? 1 : 0;
    const SimTime free = std::max(free_at(k, id), k.now());
    const auto travel_s = [&](SimTime t) {
      return nav::travel_time_s(kDetour * (expected_place(k, id, t) - k.position()).norm(),
                                k.limits());
    };
    const SimTime arrive = k.now() + Duration::from_s(travel_s(free));
    const bool idle = free <= arrive + Duration::from_s(kIdleSlack_s);
    const bool informed =
        k.knows(id, store::RecordClass::kPlan, robot::plan_key(mission::PlanKind::kAllocation));
    bool wanted = false;
    if (exploring) {
      const bool long_idle = (k.now() - free_at(k, id)).s() > kIdleLong_s;
      wanted = idle && (open_.size() >= kWorthAVisit || (!open_.empty() && long_idle));
    } else {
      wanted = holds > 0 || !informed || (!open_.empty() && idle);
    }
    if (!wanted) continue;
    // When it is free it is done with everything: come then, or as soon as one can.
    const SimTime at = std::max(arrive, free);
    const double cost_s = (at - k.now()).s();
    if (cost_s < best_s) {
      best_s = cost_s;
      best = Visit{id, expected_place(k, id, at), at};
    }
  }
  return best;
}

void Subgroup::missed(robot::Knowledge& k, RobotId id) {
  Mate& mate = mates_.at(id);
  at_gathering_[id] = true;  // where it goes when nobody comes
  if (++mate.missed >= 3) {
    mate.lost = true;
    mission::Status lost;
    lost.kind = mission::StatusKind::kLost;
    lost.robot = id;
    k.publish(store::RecordClass::kRequest, robot::lost_key(id), lost);
  }
}

}  // namespace muster::agent
