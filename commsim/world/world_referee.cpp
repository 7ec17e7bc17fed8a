#include <algorithm>
#include <cmath>

#include "common/core/error.h"
#include "commsim/world/bounds.h"
#include "commsim/world/world_impl.h"

namespace muster::world {
namespace {

constexpr double kCoverageGoal = 0.95;
constexpr double kHomeM = 1.5;  // a landing counts as at the start within this, horizontally
constexpr double kStandingMps = 0.05, kStoodS = 3;  // a rover that only turns stands for less
constexpr double kParkedS = 20;  // a rover that stands this long does not go on: it may only turn

nlohmann::json seconds(const std::optional<SimTime>& t) {
  return t ? nlohmann::json(t->decimal_s()) : nlohmann::json(nullptr);
}

nlohmann::json number(const std::optional<double>& v) {
  return v ? nlohmann::json(*v) : nlohmann::json(nullptr);
}

}  // namespace

void World::Impl::event(const char* what, nlohmann::json details, SimTime at) {
  details["t_s"] = at.decimal_s();
  details["event"] = what;
  events.push_back(std::move(details));
}

void World::Impl::violation(const std::string& what) {
  ++violations;
  event("rule_violation", {{"what", what}}, now);
}

void World::Impl::record_answer(RobotId by, const InspectionCamera::Answer& answer) {
  for (const FeatureId id : ledger.answered(by, answer.message, answer.message.time)) {
    event("inspected", {{"feature", id.value}, {"robot", by.value}}, answer.message.time);
  }
}

/// After every tick's motion: who worked, and whether everybody is home.
void World::Impl::account() {
  if (!declared) {
    std::vector<ActivityMeter::Doing> doing;
    for (const Robot& r : robots) {
      doing.push_back({r.alive, r.inspector.busy(), r.vehicle.velocity_mps().norm()});
    }
    activity.tick(doing);
  }
  for (Robot& r : robots) {
    if (r.vehicle.velocity_mps().norm() >= kStandingMps) r.moved_at = now;
  }
  if ((declared || called_home) && !home_at && home()) home_at = now;
}

bool World::Impl::home() const {
  return std::all_of(robots.begin(), robots.end(), [&](const Robot& r) {
    if (!r.alive) return true;
    const Vec3 off = r.vehicle.pose().p - r.config.start.p;
    const bool standing = r.config.vehicle.ground && (now - r.moved_at).s() >= kStoodS;
    return (r.vehicle.resting() || standing) && std::hypot(off.x(), off.y()) <= kHomeM;
  });
}

/// Has landed; or, of a rover, will not go on.
bool World::Impl::parked(const Robot& r) const {
  if (!r.config.vehicle.ground) return r.vehicle.resting();
  return (now - r.moved_at).s() >= kParkedS;
}

bool World::Impl::all_landed() const {
  return home_at ||
         std::all_of(robots.begin(), robots.end(), [&](const Robot& r) { return parked(r); });
}

void World::Impl::come_back(Lost& l) {
  l.revived = now;
  l.journal = mission::lost_journal(mission.script, l.robot, l.at, now + kTick);
  if (!l.journal || l.robot != mission.station()) return;
  ledger.station_lost_all();
  coverage.station_lost_all();
  covered_at.reset();
}

/// What was inspected by robots that died for good, or whose disk is lost, and never told: that had
/// to be, or has to be, done again.
nlohmann::json World::Impl::features_redone() const {
  std::map<RobotId, SimTime> gone;  // and what of its work may be: all before
  for (const Lost& l : lost) {
    if (l.journal) gone[l.robot] = l.at;
    if (!l.revived) gone[l.robot] = FeatureLedger::kEver;
  }
  auto all = nlohmann::json::array();
  for (const auto& [robot, until] : gone) {
    for (const FeatureLedger::Redone& r : ledger.lost_with(robot, until)) {
      all.push_back(
          {{"feature", r.feature.value},
           {"lost_with", robot.value},
           {"inspected_s", r.inspected.decimal_s()},
           {"again_s", seconds(r.again)},
           {"again_by", r.again ? nlohmann::json(r.again_by.value) : nlohmann::json(nullptr)}});
    }
  }
  return all;
}

void World::station_received(const store::Record& record, mission::MessageClass cls) {
  Impl& w = *impl_;
  try {
    if (cls == mission::MessageClass::kMapBlock) {
      w.coverage.received(record);
      if (!w.covered_at && w.coverage.share() >= kCoverageGoal) w.covered_at = w.now;
    } else if (cls == mission::MessageClass::kInspection) {
      const FeatureLedger::Receipt receipt = w.ledger.received(record, w.now);
      if (!receipt.violation.empty()) w.violation(receipt.violation);
      for (const FeatureId id : receipt.delivered) {
        w.event("delivered", {{"feature", id.value}, {"robot", record.header.author.robot.value}},
                w.now);
      }
    }
  } catch (const BadInput& e) {
    w.violation("a record of robot " + std::to_string(record.header.author.robot.value) +
                " that cannot be read: " + e.what());
  }
}

void World::station_declares_complete() {
  Impl& w = *impl_;
  if (w.declared) return;
  w.declared = true;
  w.declared_at = w.now;
  w.event("declared", {{"delivered", w.ledger.count_delivered()}, {"features", w.ledger.total()}},
          w.now);
}

World::Progress World::progress() const {
  const Impl& w = *impl_;
  Progress p;
  p.map_coverage = w.coverage.share();
  p.features_total = static_cast<std::uint32_t>(w.ledger.total());
  p.features_found = w.ledger.count_sighted();
  p.features_inspected = w.ledger.count_inspected();
  p.features_delivered = w.ledger.count_delivered();
  p.collisions = w.collisions;
  p.declared = w.declared;
  p.all_landed = w.all_landed();
  return p;
}

nlohmann::json World::summary() const {
  const Impl& w = *impl_;
  const auto total = static_cast<std::uint32_t>(w.ledger.total());
  const std::uint32_t delivered = w.ledger.count_delivered();
  const auto all_delivered = w.ledger.delivered_time(total);
  std::optional<SimTime> both;
  if (all_delivered && w.covered_at) both = std::max(*all_delivered, *w.covered_at);
  const auto share94 = static_cast<std::uint32_t>(std::ceil(0.94 * total - 1e-9));

  nlohmann::json s;
  s["mission"] = w.mission.name;
  s["strategy"] = w.mission.strategy;
  s["seed"] = w.mission.seed;
  s["complete"] = w.declared && delivered == total;
  s["declared"] = w.declared;
  s["simulated_s"] = w.now.decimal_s();
  s["time_limit_s"] = w.mission.time_limit_s;
  s["t_s"] = seconds(both);
  s["delivered_time_s"] = seconds(all_delivered);
  s["t_94_s"] = seconds(w.ledger.delivered_time(share94));
  s["covered_time_s"] = seconds(w.covered_at);
  s["finish_time_s"] = seconds(w.declared_at);
  s["home_time_s"] = seconds(w.home_at);
  s["finish_rate"] = total == 0 ? 1.0 : static_cast<double>(delivered) / total;
  s["features_total"] = total;
  s["features_sighted"] = w.ledger.count_sighted();
  s["features_inspected"] = w.ledger.count_inspected();
  s["features_delivered"] = delivered;
  s["areas"] = {{"true_inspected", w.ledger.areas().real},
                {"false_inspected", w.ledger.areas().empty},
                {"duplicate_inspected", w.ledger.areas().duplicate}};
  s["map_coverage"] = w.coverage.share();
  s["surface_voxels"] = w.coverage.total();
  const auto idle = w.activity.idle(), waste = w.activity.waste();
  s["idle_time_s"] = {{"gcs", idle.gcs_s},
                      {"explorers", idle.explorers_s},
                      {"inspectors", idle.inspectors_s},
                      {"total", idle.total()}};
  s["waste_time_s"] = {{"explorers", waste.explorers_s},
                       {"inspectors", waste.inspectors_s},
                       {"total", waste.total()}};
  s["collisions"] = w.collisions;
  s["rule_violations"] = w.violations;
  s["min_separation_m"] = number(w.contacts.min_separation_m());
  s["min_clearance_m"] = number(w.contacts.min_clearance_m());
  s["lower_bound_s"] = lower_bound_s(w.mission, w.features.features);
  s["robots_lost"] = nlohmann::json::array();
  for (const Impl::Lost& l : w.lost) {
    s["robots_lost"].push_back(
        {{"robot", l.robot.value}, {"t_s", l.at.decimal_s()}, {"revived_s", seconds(l.revived)}});
  }
  s["features_redone"] = w.features_redone();
  s["robots"] = nlohmann::json::array();
  for (std::size_t i = 0; i < w.robots.size(); ++i) {
    const Impl::Robot& r = w.robots[i];
    s["robots"].push_back({{"robot", r.config.id.value},
                           {"role", static_cast<std::uint32_t>(r.config.role)},
                           {"worked_s", w.activity.worked_s(i)},
                           {"way_m", r.way_m},
                           {"charge", w.energy.battery(i).charge}});
  }
  s["settings"] = {{"sighting_rate_hz", w.mission.sensing.sighting_rate_hz},
                   {"sighting_range_m", w.mission.sensing.sighting_range_m},
                   {"sighting_probability", w.mission.sensing.sighting_probability},
                   {"inspect_hold_s", w.mission.inspect.hold_s},
                   {"inspect_shared", w.mission.inspect.shared},
                   {"payload_bytes", w.mission.inspect.payload_bytes},
                   {"radio", w.mission.radio.preset},
                   {"radio_range_m", w.mission.radio.range_m},
                   {"radio_line_of_sight", w.mission.radio.line_of_sight},
                   {"meeting_tolerance_s", w.mission.meeting_tolerance_s},
                   {"resolution_m", w.mission.resolution_m}};
  return s;
}

std::string World::features_csv() const { return impl_->ledger.csv(impl_->features.features); }

std::vector<nlohmann::json> World::take_events() { return std::exchange(impl_->events, {}); }

}  // namespace muster::world
