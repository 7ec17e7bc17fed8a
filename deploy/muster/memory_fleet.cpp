#include "deploy/muster/memory_fleet.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/dds/order.h"
#include "common/dds/own_clock.h"

namespace muster::command {

using mission::Message;

MemoryFleet::MemoryFleet(const mission::Mission& mission,
                         const std::shared_ptr<const world::Scene>& scene, ProcessFactory factory,
                         const world::FlightConfig& config)
    : mission_(mission),
      known_(mission.without_script()),
      factory_(std::move(factory)),
      out_(config.out),
      world_(mission_, scene),
      relay_(mission_, scene),
      flight_(mission_, world_, config) {
  if (!out_.empty()) {
    relay_.log_to(out_ + "/air.csv");
    relay_.judge_journals_in(out_);
  }
  for (const mission::RobotConfig& robot : mission_.fleet) start(robot.id);
}

MemoryFleet::~MemoryFleet() = default;

/// In memory nobody dies but by the script, so only who comes back needs a journal, and whose disk
/// will be full.
bool MemoryFleet::needs_journal(RobotId robot) const {
  return std::ranges::any_of(mission_.script, [&](const mission::ScriptedEvent& event) {
    return (event.verb == "revive" || event.verb == "full-disk") && event.concerns(robot);
  });
}

void MemoryFleet::start(RobotId robot) {
  auto process = dds::with_own_clock(factory_(known_, robot, ++starts_[robot]), mission_);
  if (!out_.empty() && needs_journal(robot)) {
    auto journal = std::make_unique<store::Journal>(store::Journal::path(out_, robot), robot,
                                                    store::Journal::Durability::kProcess);
    journals_[robot] = journal.get();
    process->keep(std::move(journal));
  }
  robots_.emplace(robot, std::move(process));
}

/// Kills and revivals due now, between ticks.
void MemoryFleet::run_script() {
  for (const mission::ScriptedEvent& event : world_.scripted(k_)) {
    const bool lives = robots_.contains(event.robot);
    if (event.verb == "kill" && lives) {
      robots_.erase(event.robot);
      journals_.erase(event.robot);
      arriving_.erase(event.robot);
      waiting_.erase(event.robot);
      flight_.robot_lost(event.robot, "scripted");
    } else if (event.verb == "revive" && !lives) {
      if (event.journal_lost && !out_.empty())
        store::Journal::lose(store::Journal::path(out_, event.robot));
      start(event.robot);
      flight_.robot_back(event.robot);
    } else {
      continue;
    }
    world_.set_alive(event.robot, !lives);
    relay_.set_alive(event.robot, !lives);
  }
}

/// What has arrived, late or just now.
std::vector<Message> MemoryFleet::take_air(RobotId robot) {
  std::vector<Message> air = std::exchange(waiting_[robot], {});
  std::ranges::move(arriving_[robot], std::back_inserter(air));
  arriving_[robot].clear();
  dds::sort_messages(air);
  return air;
}

void MemoryFleet::step_robots(const std::vector<world::World::Samples>& samples) {
  std::map<RobotId, std::vector<Message>> bus;
  for (const world::World::Samples& s : samples) bus[s.robot] = s.messages;
  commands_.clear();
  sent_.clear();
  const std::set<RobotId> paused = world_.paused(k_);
  for (auto& [id, robot] : robots_) {
    if (paused.contains(id)) {
      waiting_[id] = take_air(id);
      continue;
    }
    mission::StepInput input{
        .tick = k_, .now = time_of_tick(k_), .bus = std::move(bus[id]), .air = take_air(id)};
    dds::sort_messages(input.bus);
    if (const auto journal = journals_.find(id); journal != journals_.end()) {
      journal->second->set_disk_full(
          mission::in_force(mission_.script, "full-disk", id, input.now));
    }
    mission::StepOutput output = robot->step(input);
    flight_.robot_done({.robot = id,
                        .trace = output.trace,
                        .declares_complete = output.declares_complete,
                        .activity = output.activity,
                        .planning = std::move(output.planning)});
    for (Message& message : output.bus) commands_.push_back(std::move(message));
    if (!output.air.empty()) sent_[id] = std::move(output.air);
  }
  arriving_.clear();
  dds::sort_messages(commands_);
}

/// What a meeting would have cost if both had sent all that they know of the place.
void MemoryFleet::count_whole_maps(std::initializer_list<RobotId> met) {
  for (const RobotId id : met) {
    const auto robot = robots_.find(id);
    if (robot == robots_.end()) continue;
    const mission::WholeMapBytes bytes = robot->second->whole_map_bytes();
    whole_maps_.octree += bytes.octree;
    whole_maps_.packed += bytes.packed;
  }
}

std::optional<std::string> MemoryFleet::tick() {
  run_script();
  const std::vector<world::World::Samples> samples = world_.begin_tick(k_);
  const mission::Truth truth = world_.truth();
  flight_.tick_begins(k_, truth);
  flight_.station_heard(arriving_[mission_.station()]);
  step_robots(samples);

  commsim::Relay::Outcome radio = relay_.step(truth, sent_);
  flight_.radio_done(radio.trace);
  for (const auto& [a, b] : radio.met) count_whole_maps({a, b});
  arriving_ = std::move(radio.deliveries);
  world_.end_tick(k_, commands_);
  return flight_.end_reason(k_++, robots_.size());
}

nlohmann::json MemoryFleet::finish(const std::string& reason) {
  if (!out_.empty()) {
    for (auto& [id, robot] : robots_) robot->finish(out_);
  }
  relay_.finish();
  nlohmann::json summary = flight_.finish(reason);
  summary.update(relay_.summary());
  summary["air"]["whole_map_bytes"] = whole_maps_.packed;
  summary["air"]["whole_octree_bytes"] = whole_maps_.octree;
  return summary;
}

}  // namespace muster::command
