#include "commsim/lab_radio.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/core/log.h"
#include "common/dds/convert.h"
#include "common/dds/network.h"
#include "common/dds/order.h"
#include "commsim/world/tracks.h"

namespace muster::commsim {
namespace {

using mission::Message;
using mission::MessageClass;
using Clock = dds::Inbox::Clock;

dds::ParticipantConfig sim_config(const LabOptions& options) {
  dds::ParticipantConfig config;
  config.vendor = dds::vendor_from(options.vendor);
  config.domain = options.domain;
  config.participant = dds::kRadioOnBus;
  config.star = false;
  return config;
}

dds::ParticipantConfig air_config(const LabOptions& options) {
  if (!options.network_interface.empty()) dds::await_carrier(options.network_interface);
  dds::ParticipantConfig config;
  config.vendor = dds::vendor_from(options.vendor);
  config.profile = dds::profile_from(options.profile);
  config.domain = options.domain + 1;
  config.participant = dds::kWorldOnAir;
  config.star = false;
  config.network_interface = options.network_interface;
  config.peers = options.peers;
  return config;
}

}  // namespace

LabRadio::LabRadio(const LabOptions& options, Tell tell)
    : mission_(mission::Mission::load(options.mission_file, options.set, options.faults)),
      tell_(std::move(tell)),
      relay_(mission_, world::Scene::load(mission_)),
      tracks_(options.out + "/tracks.csv"),
      sim_(dds::make_participant(sim_config(options))),
      air_(dds::make_participant(air_config(options))) {
  if (!tracks_) throw Failure(options.out + "/tracks.csv: cannot be written");
  tracks_ << world::kTrackColumns << '\n';
  relay_.log_to(options.out + "/air.csv");
  const auto once = dds::Delivery::kBestEffort;
  // Best effort matches a bridge that is reliable as well as one that is not.
  poses_reader_.add(*sim_, MessageClass::kTruth, dds::kSimPartition, inbox_.on_message(), {}, once);
  for (MessageClass cls : mission::kAirClasses) {
    up_.add(*air_, cls, "up.*", inbox_.on_message(), {}, once);
    for (const mission::RobotConfig& robot : mission_.fleet)
      down_[robot.id].add(*air_, cls, dds::down_partition(robot.id), {}, once);
  }
}

SimTime LabRadio::now() const {
  return {std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start_).count()};
}

void LabRadio::run(const std::function<bool()>& stop) {
  start_ = Clock::now();
  for (std::uint64_t k = 0; !stop();) {
    // Ticks that were slept through are left out.
    k = std::max(k + 1, static_cast<std::uint64_t>(now().us / kTick.us));
    const auto due = start_ + std::chrono::microseconds(time_of_tick(k).us);
    while (Clock::now() < due) take(due);
    step(k);
  }
}

void LabRadio::take(Clock::time_point due) {
  for (Message& message : inbox_.take(due)) {
    try {
      sort_in(std::move(message));
    } catch (const BadInput& e) {
      log::warn("refused a message: {}", e.what());
    }
  }
}

void LabRadio::sort_in(Message&& message) {
  if (message.cls == MessageClass::kTruth) {
    const auto frame = dds::decode<mission::Truth>(message);
    for (const mission::TrueState& state : frame.robots) {
      if (!mission_.has(state.robot) && strangers_.insert(state.robot).second)
        log::warn("poses of a robot {}, which the mission does not have", state.robot.value);
    }
    poses_.hear(frame, now());
    return;
  }
  const RobotId sender = dds::peek_envelope(message.cdr).src;
  if (mission_.has(sender) && heard_.insert(sender).second) {
    log::info("robot {} speaks", sender.value);
    tell_({{"heard", sender.value}});
  }
  sent_[sender].push_back(std::move(message));
}

void LabRadio::step(std::uint64_t k) {
  mission::Truth truth;
  truth.k = k;
  truth.time = stepped_ = time_of_tick(k);
  log::set_time(truth.time);
  locate(truth);
  if (k % world::kTrackEvery == 0) write_tracks(truth);
  for (auto& [robot, messages] : sent_) dds::sort_messages(messages);
  const Relay::Outcome outcome = relay_.step(truth, sent_);
  sent_.clear();
  for (const auto& [robot, messages] : outcome.deliveries) {
    for (const Message& message : messages) down_.at(robot).write(message);
  }
}

void LabRadio::locate(mission::Truth& truth) {
  for (const mission::RobotConfig& robot : mission_.fleet) {
    const auto pose = poses_.at(robot.id, truth.time);
    relay_.set_located(robot.id, pose.has_value());
    note_pose(robot.id, pose.has_value());
    if (pose)
      truth.robots.push_back({robot.id, mission::VehicleState::kMoving, *pose, Vec3::Zero()});
  }
}

/// Says once that a robot is out of sight, when it was seen before or has something to say.
void LabRadio::note_pose(RobotId robot, bool known) {
  if (known) {
    if (!located_.insert(robot).second) return;
    log::info("robot {} is seen", robot.value);
  } else {
    const bool lost = located_.erase(robot) > 0;
    const bool early = stepped_ - SimTime{} < PoseTable::kPoseLimit;
    if (!lost && (early || !sent_.contains(robot) || missed_.contains(robot))) return;
    log::warn("robot {}: no pose for {} s: it is unheard and hears nothing", robot.value,
              PoseTable::kPoseLimit.s());
  }
  if (known) missed_.erase(robot);
  if (!known) missed_.insert(robot);
  tell_({{"pose", robot.value}, {"known", known}});
}

void LabRadio::write_tracks(const mission::Truth& truth) {
  for (const mission::TrueState& robot : truth.robots)
    tracks_ << world::track_row(truth.time, robot) << '\n';
}

nlohmann::json LabRadio::finish() {
  relay_.finish();
  tracks_.flush();
  nlohmann::json summary = relay_.summary();
  auto fleet = nlohmann::json::array();
  for (const mission::RobotConfig& robot : mission_.fleet)
    fleet.push_back({{"id", robot.id.value}, {"role", mission::role_name(robot.role)}});
  summary.update({{"mission", mission_.name},
                  {"transport", "lab"},
                  {"simulated_s", stepped_.s()},
                  {"fleet", std::move(fleet)}});
  return summary;
}

}  // namespace muster::commsim
