#include "gcs/strategy/regions.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/route/share.h"

namespace muster::gcs {
namespace {

using State = mission::RegionState;

/// Every area known here has its result here, image and all.
bool results_complete(const robot::Knowledge& k, RegionId region) {
  return std::ranges::all_of(k.areas(), [&](const auto& a) {
    return a.second.area.region != region || k.result_complete(a.first);
  });
}

}  // namespace

Regions::Regions(const mission::Mission& mission) : regions_(mission.boxes.size()) {
  for (const RobotId explorer : mission.with_role(mission::Role::kExplorer))
    groups_[explorer].explorer = explorer;
}

/// The nearest that is pending; else of those that this explorer surveyed; else of all surveyed.
std::optional<RegionId> Regions::next_for(RobotId explorer, const Vec3& from,
                                          const robot::Knowledge& k) const {
  const auto nearest = [&](const auto& eligible) {
    std::optional<RegionId> best;
    double best_m = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < regions_.size(); ++i) {
      const double m = (k.mission().boxes[i].center - from).norm();
      if (eligible(regions_[i]) && m < best_m)
        best_m = m, best = RegionId{static_cast<std::uint32_t>(i)};
    }
    return best;
  };
  auto best = nearest([](const Region& r) { return r.state == State::kPending; });
  if (!best) {
    best = nearest(
        [&](const Region& r) { return r.state == State::kSurveyed && r.surveyor == explorer; });
  }
  if (!best) best = nearest([](const Region& r) { return r.state == State::kSurveyed; });
  return best;
}

/// Every explorer says which region it works on, and its allocation names its inspectors.
void Regions::leave_at_work(const robot::Knowledge& k) {
  for (auto& [id, group] : groups_) {
    const auto* health = k.health(id);
    if (!health || health->body.regions.empty()) continue;
    const RegionId region = health->body.regions.front().region;
    if (region.value >= regions_.size() || regions_[region.value].state != State::kPending)
      continue;
    group.region = region;
    regions_[region.value].state = State::kAssigned;
    const auto* crew = k.plan(id, mission::PlanKind::kAllocation);
    if (!crew) continue;
    for (const mission::Allocation& a : crew->body.allocations) {
      if (a.area.author == kNoRobot && std::erase(orphans_, a.robot) > 0)
        group.inspectors.push_back(a.robot);
    }
  }
}

void Regions::assign_all(robot::Knowledge& k) {
  std::vector<double> volumes;
  std::vector<RobotId> working;
  orphans_ = k.mission().with_role(mission::Role::kInspector);
  leave_at_work(k);
  for (auto& [explorer, group] : groups_) {
    if (group.region == kNoRegion) {
      group.region = next_for(explorer, k.mission().robot(explorer).start.p, k).value_or(kNoRegion);
      group.released = group.region == kNoRegion;
    }
    if (group.released) continue;
    regions_[group.region.value].state = State::kAssigned;
    volumes.push_back(k.mission().boxes[group.region.value].volume());
    working.push_back(explorer);
  }
  const auto inspectors = std::exchange(orphans_, {});
  const auto shares =
      route::share_inspectors(static_cast<std::uint32_t>(inspectors.size()), volumes);
  std::size_t next = 0;
  for (std::size_t i = 0; i < working.size(); ++i) {
    for (std::uint32_t n = 0; n < shares[i] && next < inspectors.size(); ++n)
      groups_[working[i]].inspectors.push_back(inspectors[next++]);
  }
  publish(k);
}

bool Regions::resume(robot::Knowledge& k) {
  const auto* kept = k.plan(k.self(), mission::PlanKind::kAssignment);
  if (!kept) return false;
  orphans_ = k.mission().with_role(mission::Role::kInspector);
  for (const mission::Allocation& a : kept->body.allocations) {
    // What does not fit was kept of another mission.
    const RobotId explorer = a.leader == kNoRobot ? a.robot : a.leader;
    if (a.region != kNoRegion && a.region.value >= regions_.size()) continue;
    if (explorer != kNoRobot && !groups_.contains(explorer)) continue;
    if (a.robot == kNoRobot && a.region == kNoRegion) continue;
    if (robot::says_done(a)) {
      regions_[a.region.value] = {State::kDone, kNoRobot};
    } else if (robot::says_surveyed(a)) {
      Region& region = regions_[a.region.value];
      region.surveyor = a.leader;
      if (region.state == State::kPending) region.state = State::kSurveyed;
    } else if (a.leader != kNoRobot) {
      groups_.at(a.leader).inspectors.push_back(a.robot);
      std::erase(orphans_, a.robot);
    } else if (a.region != kNoRegion) {
      groups_.at(a.robot).region = a.region;
      regions_[a.region.value].state = State::kAssigned;
    }
  }
  // Without a region: released when there was none left, else it had been lost.
  for (auto& [id, group] : groups_) {
    if (group.region != kNoRegion) continue;
    (next_for(id, k.position(), k) ? group.lost : group.released) = true;
  }
  publish(k);
  return true;
}

bool Regions::report(robot::Knowledge& k, RobotId explorer) {
  Group& group = groups_.at(explorer);
  if (group.lost) {
    back(k, group);
    return true;
  }
  if (reopen(k)) publish(k);
  if (group.released && next_for(explorer, k.position(), k)) {
    group.released = false;
    give(group, k.position(), k);
    publish(k);
    return true;
  }
  if (reinforce(k, group)) {
    publish(k);
    return true;
  }
  const auto* health = k.health(explorer);
  if (!health || health->body.regions.empty() || group.released) return false;
  const mission::RegionProgress& p = health->body.regions.front();
  if (p.region != group.region) return false;
  Region& region = regions_[p.region.value];
  if (p.state == State::kExplored) region.state = State::kExplored;
  const bool over =
      p.state == State::kDone || (p.state == State::kSurveyed && region.surveyor == kNoRobot);
  if (!over || !k.exchanged(explorer) || !results_complete(k, p.region)) return false;

  region.state = p.state;
  region.surveyor = explorer;
  give(group, k.mission().boxes[p.region.value].center, k);
  publish(k);
  return true;
}

/// An area that was told of late: somebody has to inspect it.
bool Regions::reopen(const robot::Knowledge& k) {
  bool any = false;
  for (const auto& [ref, known] : k.areas()) {
    const RegionId region = known.area.region;
    if (region.value >= regions_.size() || k.result_complete(ref)) continue;
    State& state = regions_[region.value].state;
    if (state != State::kDone) continue;
    state = State::kSurveyed;
    any = true;
  }
  return any;
}

/// The next region, and whoever has lost its explorer; none left: released.
void Regions::give(Group& group, const Vec3& from, const robot::Knowledge& k) {
  group.inspectors.insert(group.inspectors.end(), orphans_.begin(), orphans_.end());
  orphans_.clear();
  if (const auto next = next_for(group.explorer, from, k)) {
    group.region = *next;
    regions_[next->value].state = State::kAssigned;
  } else {
    group.region = kNoRegion;
    group.released = true;
  }
}

/// It was lost and is here: on with what it had, unless somebody else works on that by now.
void Regions::back(robot::Knowledge& k, Group& group) {
  group.lost = false;
  const RegionId held = std::exchange(group.held, kNoRegion);
  give(group, held == kNoRegion ? k.position() : k.mission().boxes[held.value].center, k);
  reinforce(k, group);
  publish(k);
}

/// Without an inspector a region is never done: half of the largest group's, or of one that has
/// nothing left to do.
bool Regions::reinforce(const robot::Knowledge& k, Group& group) {
  const auto crew = [&](const Group& g) {
    std::vector<RobotId> there;
    std::ranges::copy_if(g.inspectors, std::back_inserter(there), [&](RobotId id) {
      const auto lost = k.declared_lost().find(id);
      const auto* alive = k.health(id);
      return lost == k.declared_lost().end() || (alive && alive->header.stamp > lost->second);
    });
    return there;
  };
  if (group.region == kNoRegion || !crew(group).empty()) return false;
  Group* donor = nullptr;
  std::vector<RobotId> most;
  for (auto& [id, other] : groups_) {
    std::vector<RobotId> there = crew(other);
    if (there.size() <= most.size() || (there.size() < 2 && other.region != kNoRegion)) continue;
    donor = &other;
    most = std::move(there);
  }
  if (!donor) return false;
  most.resize((most.size() + 1) / 2);
  for (const RobotId inspector : most) {
    std::erase(donor->inspectors, inspector);
    group.inspectors.push_back(inspector);
  }
  return true;
}

void Regions::lost(robot::Knowledge& k, RobotId explorer) {
  Group& group = groups_.at(explorer);
  if (group.lost) return;
  group.lost = true;
  group.held = group.region;
  if (group.region != kNoRegion) {
    Region& region = regions_[group.region.value];
    region.state = region.surveyor == kNoRobot ? State::kPending : State::kSurveyed;
  }
  group.region = kNoRegion;
  orphans_.insert(orphans_.end(), group.inspectors.begin(), group.inspectors.end());
  group.inspectors.clear();
  mission::Status status;
  status.kind = mission::StatusKind::kLost;
  status.robot = explorer;
  k.publish(store::RecordClass::kRequest, robot::lost_key(explorer), status);
  publish(k);
}

bool Regions::all_done() const {
  return std::ranges::all_of(regions_, [](const Region& r) { return r.state == State::kDone; });
}

void Regions::publish(robot::Knowledge& k) const {
  mission::Plan plan;
  plan.kind = mission::PlanKind::kAssignment;
  for (const auto& [id, group] : groups_) {
    plan.allocations.push_back({id, kNoRobot, group.region, {}});
    for (const RobotId inspector : group.inspectors)
      plan.allocations.push_back({inspector, id, group.region, {}});
  }
  // For explorers, and for a later start: what is done, and what was surveyed by whom.
  for (std::uint32_t i = 0; i < regions_.size(); ++i) {
    const Region& region = regions_[i];
    const bool done = region.state == State::kDone;
    if (done || region.surveyor != kNoRobot)
      plan.allocations.push_back({kNoRobot, done ? kNoRobot : region.surveyor, RegionId{i}, {}});
  }
  k.publish(store::RecordClass::kPlan, robot::plan_key(mission::PlanKind::kAssignment), plan);
}

}  // namespace muster::gcs
