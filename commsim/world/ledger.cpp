#include "commsim/world/ledger.h"

#include <algorithm>
#include <cstdio>

#include "common/core/hash.h"
#include "common/dds/convert.h"

namespace muster::world {
namespace {

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", v);
  return text;
}

std::string time_text(const std::optional<SimTime>& t) { return t ? number(t->s()) : ""; }
std::string robot_text(RobotId id) { return id == kNoRobot ? "" : std::to_string(id.value); }

}  // namespace

FeatureLedger::FeatureLedger(const std::vector<Feature>& features) : entries_(features.size()) {}

bool FeatureLedger::sighted(FeatureId id, RobotId by, SimTime now) {
  Entry& e = entries_[id.value];
  if (e.sighted) return false;
  e.sighted = now;
  e.sighted_by = by;
  ++sighted_;
  return true;
}

std::vector<FeatureId> FeatureLedger::answered(RobotId by, const mission::Inspected& answer,
                                               SimTime now) {
  std::vector<FeatureId> fresh;
  if (answer.outcome == mission::InspectOutcome::kEmpty) ++areas_.empty;
  if (answer.outcome != mission::InspectOutcome::kFound) return fresh;
  Given given;
  given.at = now;
  given.payload_hash = hash_bytes(answer.payload);
  for (const mission::Finding& f : answer.found) {
    given.features.push_back(f.feature);
    Entry& e = entries_[f.feature.value];
    if (e.inspected) continue;
    e.inspected = now;
    e.inspected_by = by;
    ++inspected_;
    fresh.push_back(f.feature);
  }
  ++(fresh.empty() ? areas_.duplicate : areas_.real);
  given_[by].push_back(std::move(given));
  return fresh;
}

const FeatureLedger::Given* FeatureLedger::given_to(
    RobotId by, const std::vector<FeatureId>& ids,
    std::optional<std::uint64_t> payload_hash) const {
  const auto it = given_.find(by);
  if (it == given_.end()) return nullptr;
  for (const Given& g : it->second) {
    const bool all = std::all_of(ids.begin(), ids.end(), [&](FeatureId id) {
      return std::find(g.features.begin(), g.features.end(), id) != g.features.end();
    });
    if (all && (!payload_hash || *payload_hash == g.payload_hash)) return &g;
  }
  return nullptr;
}

FeatureLedger::Receipt FeatureLedger::received(const store::Record& record, SimTime now) {
  const auto body = dds::decode_body<mission::Inspection>(record);
  const RobotId by = record.header.author.robot;
  Arrival& arrival = arrivals_[{by, body.area, body.done}];
  if (arrival.settled) return {};
  if (body.part == 0) {
    if (!body.found) {
      arrival.settled = true;
      return {};
    }
    arrival.features.clear();
    for (const mission::Finding& f : body.findings) arrival.features.push_back(f.feature);
    if (!given_to(by, arrival.features, std::nullopt)) {
      arrival.settled = true;
      return {{}, "robot " + robot_text(by) + " reports a feature the world never showed it"};
    }
    arrival.has_result = true;
    arrival.parts = std::max(1u, body.parts);
  }
  arrival.payload[body.part] = body.payload;
  if (!arrival.has_result || arrival.payload.size() < arrival.parts) return {};
  return settle(by, arrival, now);
}

FeatureLedger::Receipt FeatureLedger::settle(RobotId by, Arrival& arrival, SimTime now) {
  Receipt receipt;
  arrival.settled = true;
  Bytes image;
  for (const auto& [part, bytes] : arrival.payload) {
    image.insert(image.end(), bytes.begin(), bytes.end());
  }
  arrival.payload.clear();
  const Given* given = given_to(by, arrival.features, hash_bytes(image));
  if (!given) {
    receipt.violation = "robot " + robot_text(by) + " delivers an image the world never gave it";
    return receipt;
  }
  for (const FeatureId id : arrival.features) {
    Entry& e = entries_[id.value];
    if (e.delivered) continue;
    e.delivered = now;
    e.delivered_by = by;
    e.delivered_look = given->at;
    ++delivered_;
    deliveries_.push_back(now);
    receipt.delivered.push_back(id);
  }
  return receipt;
}

std::vector<FeatureLedger::Redone> FeatureLedger::lost_with(RobotId robot, SimTime until) const {
  std::map<FeatureId, Redone> lost;
  const auto own = given_.find(robot);
  if (own == given_.end()) return {};
  for (const Given& g : own->second) {
    if (g.at >= until) break;
    for (const FeatureId id : g.features) {
      const Entry& e = entries_[id.value];
      if (e.delivered_by != robot || e.delivered_look >= until)
        lost.try_emplace(id, Redone{id, g.at, {}});
    }
  }
  for (const auto& [other, answers] : given_) {
    for (const Given& g : answers) {
      if (other == robot && g.at < until) continue;
      for (const FeatureId id : g.features) {
        const auto it = lost.find(id);
        if (it == lost.end()) continue;
        Redone& redone = it->second;
        if (g.at <= redone.inspected) {
          // It had been done before, and that reached the station.
          if (entries_[id.value].delivered_by == other) lost.erase(it);
        } else if (!redone.again || g.at < *redone.again) {
          redone.again = g.at;
          redone.again_by = other;
        }
      }
    }
  }
  std::vector<Redone> all;
  all.reserve(lost.size());
  for (const auto& [id, redone] : lost) all.push_back(redone);
  return all;
}

void FeatureLedger::station_lost_all() {
  for (Entry& e : entries_) {
    e.delivered.reset();
    e.delivered_by = kNoRobot;
  }
  arrivals_.clear();
  deliveries_.clear();
  delivered_ = 0;
}

std::optional<SimTime> FeatureLedger::delivered_time(std::uint32_t count) const {
  if (count == 0) return SimTime{};
  if (deliveries_.size() < count) return std::nullopt;
  return deliveries_[count - 1];
}

std::string FeatureLedger::csv(const std::vector<Feature>& features) const {
  std::string text = "id,type,x,y,z,sighted_s,sighted_by,inspected_s,inspected_by,delivered_s\n";
  for (const Feature& f : features) {
    const Entry& e = entries_[f.id.value];
    text += std::to_string(f.id.value) + "," + std::to_string(f.type) + "," +
            number(f.position.x()) + "," + number(f.position.y()) + "," + number(f.position.z()) +
            "," + time_text(e.sighted) + "," + robot_text(e.sighted_by) + "," +
            time_text(e.inspected) + "," + robot_text(e.inspected_by) + "," +
            time_text(e.delivered) + "\n";
  }
  return text;
}

}  // namespace muster::world
