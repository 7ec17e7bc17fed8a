#include "commsim/promises.h"

#include <algorithm>
#include <filesystem>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/convert.h"
#include "common/store/journal.h"

namespace muster::commsim {
namespace {

constexpr std::size_t kNamed = 50;

}  // namespace

void Promises::sent(RobotId by, const mission::Message& message) try {
  if (message.cls == mission::MessageClass::kBeacon) {
    digest(by, dds::decode<mission::Beacon>(message));
  } else if (mission::is_record(message.cls)) {
    const store::RecordHeader h = dds::peek_header(message);
    on_air_[{h.author.robot, h.cls, h.key}].insert(h.version());
  }
} catch (const BadInput&) {
  // Its hearers refuse it as well.
}

void Promises::digest(RobotId by, const mission::Beacon& beacon) {
  if (beacon.digest_n == 0) return;
  for (const store::DigestEntry& e : beacon.digest) {
    Promise& promise = promises_[by][{e.author.robot, e.cls, e.author.epoch}];
    for (const store::SeqRange& range : e.beyond) promise.beyond.insert(range);
    promise.complete = promise.beyond.advance(std::max(promise.complete, e.complete));
  }
}

/// The newest version of `name` that `robot` said it holds.
std::optional<Promises::Version> Promises::promised(RobotId robot, const Name& name,
                                                    const std::set<Version>& versions) const {
  const auto& streams = promises_.at(robot);
  for (auto version = versions.rbegin(); version != versions.rend(); ++version) {
    const auto promise = streams.find({name.author, name.cls, version->first});
    if (promise != streams.end() && promise->second.covers(version->second)) return *version;
  }
  return std::nullopt;
}

void Promises::judge(RobotId robot, std::span<const store::RecordHeader> journal, SimTime now) {
  judged_.insert(robot);
  if (!promises_.contains(robot)) return;
  std::map<Name, Version> held;
  std::map<RobotId, std::uint64_t> newest_epoch;
  for (const store::RecordHeader& h : journal) {
    held[{h.author.robot, h.cls, h.key}] = h.version();
    std::uint64_t& newest = newest_epoch[h.author.robot];
    newest = std::max(newest, h.author.epoch);
  }
  for (const auto& [name, versions] : on_air_) {
    const auto version = promised(robot, name, versions);
    if (!version) continue;
    const auto holds = held.find(name);
    if (holds != held.end() && holds->second >= *version) continue;
    const bool voided =
        store::voided_by_restart(name.cls) && newest_epoch[name.author] > version->first;
    if (voided || !lost_.try_emplace({robot, name}, Loss{*version, now}).second) continue;
    log::error("robot {} had promised to hold {}.{} of robot {}'s {}, key {}, and does not",
               robot.value, version->first, version->second, name.author.value,
               mission::topic_name(mission::message_class(name.cls)), name.key);
  }
}

void Promises::judge_file(RobotId robot, const std::string& path, SimTime now) {
  if (!std::filesystem::exists(path)) return;
  try {
    judge(robot, store::Journal::kept(path), now);
  } catch (const Failure& e) {
    log::error("robot {}'s journal cannot be judged: {}", robot.value, e.what());
  }
}

void Promises::disk_lost(RobotId robot) { promises_.erase(robot); }

nlohmann::json Promises::to_json() const {
  auto records = nlohmann::json::array();
  for (const auto& [what, loss] : lost_) {
    if (records.size() == kNamed) break;
    const auto& [robot, name] = what;
    records.push_back({{"robot", robot.value},
                       {"author", name.author.value},
                       {"epoch", loss.version.first},
                       {"class", mission::topic_name(mission::message_class(name.cls))},
                       {"key", name.key},
                       {"seq", loss.version.second},
                       {"t_s", loss.at.decimal_s()}});
  }
  return {{"count", lost_.size()}, {"journals", judged_.size()}, {"records", std::move(records)}};
}

}  // namespace muster::commsim
