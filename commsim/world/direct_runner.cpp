#include "commsim/world/direct_runner.h"

#include <chrono>
#include <map>
#include <optional>
#include <set>

#include "common/core/log.h"
#include "common/dds/barrier.h"
#include "common/dds/convert.h"
#include "common/dds/inbox.h"
#include "common/dds/order.h"
#include "commsim/world/flight.h"
#include "commsim/world/pacer.h"
#include "commsim/world/world.h"

namespace muster::world {
namespace {

using mission::Message;
using mission::MessageClass;
using Clock = dds::Inbox::Clock;

dds::ParticipantConfig participant(const RunnerOptions& options, std::uint32_t domain,
                                   std::uint32_t number, bool star) {
  dds::ParticipantConfig config;
  config.vendor = dds::vendor_from(options.vendor);
  config.domain = domain;
  config.participant = number;
  config.star = star;
  return config;
}

class DirectRunner {
 public:
  explicit DirectRunner(const RunnerOptions& options)
      : options_(options),
        control_(options.control_fd),
        mission_(mission::Mission::load(options.mission_file, options.set)),
        world_(mission_, Scene::load(mission_)),
        flight_(mission_, world_,
                {.out = options.out, .duration_s = options.duration_s, .trace = false}),
        bus_(dds::make_participant(participant(options, options.domain, 0, true))),
        air_(dds::make_participant(
            participant(options, options.domain + 1, dds::kWorldOnAir, false))) {
    commands_reader_ = dds::ReaderSet(*bus_, dds::kCommandClasses, "bus.*", inbox_.on_message(),
                                      inbox_.on_match());
    for (MessageClass cls : mission::kAirClasses) {
      air_reader_.add(*air_, cls, dds::kAirPartition, inbox_.on_message(), {},
                      dds::Delivery::kBestEffort);
    }
    for (const mission::RobotConfig& robot : mission_.fleet) {
      dds::WriterSet ways(*bus_, dds::kSampleClasses, dds::bus_partition(robot.id),
                          inbox_.on_match());
      if (robot.id == mission_.station()) {
        ways.add(*bus_, MessageClass::kOperatorRequest, dds::bus_partition(robot.id),
                 inbox_.on_match());
      }
      ways_.emplace(robot.id, std::move(ways));
    }
    control_.on_dead([this](RobotId) { inbox_.wake(); });
  }
  ~DirectRunner() { control_.on_dead({}); }

  int run() {
    await_drivers();
    control_.tell({{"matched", true}});
    control_.tell({{"started", true}, {"load_s", load_s_}});
    const std::string reason = fly();
    nlohmann::json summary = flight_.finish(reason);
    summary["trace_hash"] = nullptr;  // everyone had their own clock
    control_.tell({{"summary", std::move(summary)}});
    control_.await_hang_up();
    return 0;
  }

 private:
  /// Every robot has its drivers: an odometry sample written before that would be lost on it.
  void await_drivers() {
    const auto deadline =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(dds::BarrierConfig{}.start);
    const auto matched = [&] {
      return std::all_of(ways_.begin(), ways_.end(),
                         [](const auto& way) { return way.second.matched(1); });
    };
    while (!matched() && control_.stop_reason().empty()) {
      inbox_.take(deadline);
      if (Clock::now() >= deadline) throw Failure("not every robot was matched on the bus");
    }
  }

  std::string fly() {
    const Pacer pacer(options_.speed > 0 ? options_.speed : 1);
    for (std::uint64_t k = 0;; ++k) {
      log::set_time(time_of_tick(k));
      for (const World::Samples& samples : world_.begin_tick(k)) {
        const auto way = ways_.find(samples.robot);
        if (way == ways_.end()) continue;
        for (const Message& sample : samples.messages) way->second.write(sample);
      }
      flight_.tick_begins(k, world_.truth());
      pacer.wait_until(time_of_tick(k + 1));
      take_what_arrived();
      dds::sort_messages(commands_);
      world_.end_tick(k, commands_);
      commands_.clear();
      if (k % 10 == 0) control_.tell({{"progress", flight_.progress()}});
      for (const auto& [verb, robot] : control_.take_requests()) flight_.request(verb, robot);
      if (auto reason = flight_.end_reason(k, ways_.size())) return *std::move(reason);
      if (std::string reason = control_.stop_reason(); !reason.empty()) return reason;
    }
  }

  void take_what_arrived() {
    std::vector<Message> heard;
    for (Message& message : inbox_.take(Clock::now())) {
      if (!mission::is_air(message.cls)) {
        commands_.push_back(std::move(message));
      } else if (dds::peek_envelope(message.cdr).src != mission_.station()) {
        if (message.cls == MessageClass::kBeacon) note_activity(message);
        heard.push_back(std::move(message));
      } else if (message.cls == MessageClass::kBeacon) {
        note_activity(message);
      } else if (message.cls == MessageClass::kStatus) {
        note_declaration(message);
      }
    }
    flight_.station_heard(heard);
    for (RobotId robot : control_.take_dead()) {
      if (ways_.erase(robot) == 0) continue;
      flight_.robot_lost(robot, control_.how_lost(robot));
      world_.set_alive(robot, false);
    }
  }

  void note_activity(const Message& message) {
    const auto beacon = dds::decode<mission::Beacon>(message);
    flight_.robot_done({.robot = beacon.envelope.src,
                        .trace = 0,
                        .declares_complete = false,
                        .activity = beacon.activity,
                        .planning = {}});
  }

  void note_declaration(const Message& message) {
    const store::Record record = dds::unwrap(message);
    if (record.header.author.robot != mission_.station()) return;
    if (dds::decode_body<mission::Status>(record).kind != mission::StatusKind::kComplete) return;
    flight_.robot_done({.robot = mission_.station(),
                        .trace = 0,
                        .declares_complete = true,
                        .activity = {},
                        .planning = {}});
  }

  const RunnerOptions options_;
  RunControl control_;
  const mission::Mission mission_;
  const Clock::time_point begun_ = Clock::now();
  World world_;
  Flight flight_;
  const double load_s_ = std::chrono::duration<double>(Clock::now() - begun_).count();
  dds::Inbox inbox_;
  std::unique_ptr<dds::Participant> bus_, air_;
  dds::ReaderSet commands_reader_, air_reader_;
  std::map<RobotId, dds::WriterSet> ways_;
  std::vector<Message> commands_;
};

}  // namespace

int run_direct(const RunnerOptions& options) { return DirectRunner(options).run(); }

}  // namespace muster::world
