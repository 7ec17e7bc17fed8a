#include "gcs/strategy/regions.h"

#include <algorithm>
#include <utility>

#include "common/route/allocate.h"

namespace muster::gcs {

Regions::Regions(const mission::Mission& mission)
    : states_(mission.boxes.size(), mission::RegionState::kPending) {
  for (const RobotId explorer : mission.with_role(mission::Role::kExplorer))
    groups_[explorer].explorer = explorer;
}

std::optional<RegionId> Regions::nearest_pending(const robot::Knowledge& k,
                                                 const Vec3& from) const {
  std::optional<RegionId> best;
  double best_m = 1e18;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (states_[i] != mission::RegionState::kPending) continue;
    const double d = (k.mission().boxes[i].center - from).norm();
    if (d < best_m) best_m = d, best = RegionId{static_cast<std::uint32_t>(i)};
  }
  return best;
}

/// Every explorer says which region it works on, and its allocation names its inspectors.
void Regions::leave_at_work(const robot::Knowledge& k) {
  for (auto& [id, group] : groups_) {
    const auto* health = k.health(id);
    if (!health || health->body.regions.empty()) continue;
    const RegionId region = health->body.regions.front().region;
    if (region.value >= states_.size() || states_[region.value] != mission::RegionState::kPending)
      continue;
    group.region = region;
    states_[region.value] = mission::RegionState::kAssigned;
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
      group.region = nearest_pending(k, k.mission().robot(explorer).start.p).value_or(kNoRegion);
      group.released = group.region == kNoRegion;
    }
    if (group.released) continue;
    states_[group.region.value] = mission::RegionState::kAssigned;
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
    if (a.region != kNoRegion && a.region.value >= states_.size()) continue;
    if (explorer != kNoRobot && !groups_.contains(explorer)) continue;
    if (a.robot == kNoRobot && a.region == kNoRegion) continue;
    if (a.robot == kNoRobot) {
      states_[a.region.value] = mission::RegionState::kDone;
    } else if (a.leader != kNoRobot) {
      groups_.at(a.leader).inspectors.push_back(a.robot);
      std::erase(orphans_, a.robot);
    } else if (a.region != kNoRegion) {
      groups_.at(a.robot).region = a.region;
      states_[a.region.value] = mission::RegionState::kAssigned;
    }
  }
  // Without a region: released when there was none left, else it had been lost.
  const bool pending = std::ranges::count(states_, mission::RegionState::kPending) > 0;
  for (auto& [id, group] : groups_) {
    group.lost = group.region == kNoRegion && pending;
    group.released = group.region == kNoRegion && !pending;
  }
  publish(k);
  return true;
}

bool Regions::results_complete(const robot::Knowledge& k, RegionId region) {
  return std::all_of(k.areas().begin(), k.areas().end(), [&](const auto& a) {
    if (a.second.area.region != region) return true;
    const auto result = k.results().find(a.first);
    return result != k.results().end() && result->second.complete();
  });
}

bool Regions::report(robot::Knowledge& k, RobotId explorer) {
  Group& group = groups_.at(explorer);
  if (group.lost) {
    back(k, group);
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
  if (p.state == mission::RegionState::kExplored)
    states_[p.region.value] = mission::RegionState::kExplored;
  if (p.state != mission::RegionState::kDone || !k.exchanged(explorer) ||
      !results_complete(k, p.region))
    return false;

  states_[p.region.value] = mission::RegionState::kDone;
  give(group, k.mission().boxes[p.region.value].center, k);
  publish(k);
  return true;
}

/// The nearest pending region, and whoever has lost its explorer; none left: released.
void Regions::give(Group& group, const Vec3& from, const robot::Knowledge& k) {
  group.inspectors.insert(group.inspectors.end(), orphans_.begin(), orphans_.end());
  orphans_.clear();
  if (const auto next = nearest_pending(k, from)) {
    group.region = *next;
    states_[next->value] = mission::RegionState::kAssigned;
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
  if (group.region != kNoRegion && states_[group.region.value] != mission::RegionState::kDone) {
    states_[group.region.value] = mission::RegionState::kPending;
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
  return std::all_of(states_.begin(), states_.end(),
                     [](auto s) { return s == mission::RegionState::kDone; });
}

void Regions::publish(robot::Knowledge& k) const {
  mission::Plan plan;
  plan.kind = mission::PlanKind::kAssignment;
  for (const auto& [id, group] : groups_) {
    plan.allocations.push_back({id, kNoRobot, group.region, {}});
    for (const RobotId inspector : group.inspectors)
      plan.allocations.push_back({inspector, id, group.region, {}});
  }
  for (std::uint32_t i = 0; i < states_.size(); ++i) {
    if (states_[i] == mission::RegionState::kDone)
      plan.allocations.push_back({kNoRobot, kNoRobot, RegionId{i}, {}});  // for a later start
  }
  k.publish(store::RecordClass::kPlan, robot::plan_key(mission::PlanKind::kAssignment), plan);
}

}  // namespace muster::gcs
