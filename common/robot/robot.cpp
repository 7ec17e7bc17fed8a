#include "common/robot/robot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/log.h"
#include "common/map/block_codec.h"
#include "common/robot/stopwatch.h"

namespace muster::robot {
namespace {

constexpr double kBeaconPeriod_s = 0.3;
constexpr double kKeepBlocks_s = 5;  // what a crash may take of the own map, when nobody was told
constexpr double kThrough_m = 2;     // to where it can fly: further up may be a roof
constexpr double kWayUp_m = 0.6;     // lower than anybody flies for long
constexpr double kWayOut_m = 1.0;
constexpr double kFreshMate_s =
    0.5;  // DESIGN "Map and motion": returns fit a teammate heard within this

/// Where the air is shared, neighbours do not send their beacons all in one tick.
SimTime first_beacon(const radio::RadioConfig& radio, RobotId self) {
  return radio.bit_rate_mbps > 0 ? time_of_tick(self.value % 3) : SimTime{};
}

}  // namespace

Robot::Robot(const mission::Mission& mission, RobotId self, std::unique_ptr<Strategy> strategy,
             std::uint64_t epoch)
    : knowledge_(mission, self, epoch),
      strategy_(std::move(strategy)),
      executive_(mission, self),
      pace_(mission.radio),
      beacon_due_(first_beacon(mission.radio, self)),
      stratum_(mission.robot(self).role == mission::Role::kStation ? 0 : 15) {}

Robot::~Robot() = default;

mission::StepOutput Robot::step(const mission::StepInput& input) {
  log::set_speaker(input.now, knowledge_.self());
  knowledge_.begin(input.now, input.clock_bound);
  take_bus(input);
  take_air(input);

  Intent intent = strategy_->decide(knowledge_, executive_.progress());
  if (auto overruled = guardian_.overrule(knowledge_)) intent = std::move(*overruled);
  if (intent.reason != intent_.reason) log::info("{}", intent.reason);
  intent_ = std::move(intent);

  mission::StepOutput output;
  {
    Executive::Commands commands;
    {
      const Stopwatch watch(planning_, mission::PlanningStep::kPath);
      commands = executive_.step(knowledge_, intent_);
    }
    if (!commands.trajectory) planning_.pop_back();  // only steps that planned count
    send_bus(std::move(commands), output);
  }
  map_sharer_.step(knowledge_);
  send_air(output);
  commit();

  output.trace = knowledge_.store().content_hash();
  output.declares_complete = strategy_->declares_complete();
  output.activity = intent_.activity;
  output.planning = std::exchange(planning_, {});
  for (const mission::PlanningTime& p : strategy_->take_planning()) output.planning.push_back(p);
  return output;
}

void Robot::keep(std::unique_ptr<store::Journal> journal) {
  journal_ = std::move(journal);
  if (journal_->epoch() == 0) return;
  knowledge_.restore(*journal_);
  kept_looks_ = knowledge_.looks().size();
  log::info("goes on with {} records and {} looks that its journal kept", knowledge_.store().size(),
            kept_looks_);
}

/// Before what this tick has to say leaves the robot.
void Robot::commit() {
  if (!journal_) return;
  if (knowledge_.now() >= keep_blocks_) {
    for (const map::BlockKey& b : knowledge_.map().own_changes(kept_blocks_))
      journal_->keep_block(map::pack(b),
                           map::encode_blocks(std::array{knowledge_.map().own_block(b)}));
    keep_blocks_ = knowledge_.now() + Duration::from_s(kKeepBlocks_s);
  }
  for (; kept_looks_ < knowledge_.looks().size(); ++kept_looks_) {
    const Look& look = knowledge_.looks()[kept_looks_];
    journal_->keep_look(look.explored, dds::encode(look.sightings).cdr);
  }
  journal_->commit(knowledge_.store());
}

mission::WholeMapBytes Robot::whole_map_bytes() { return whole_map_.bytes(knowledge_.map()); }

void Robot::finish(const std::string&) {}

void Robot::take_bus(const mission::StepInput& input) {
  for (const mission::Message& m : input.bus) {
    switch (m.cls) {
      case mission::MessageClass::kOdometry:
        find_itself(dds::decode<mission::Odometry>(m));
        break;
      case mission::MessageClass::kBattery:
        knowledge_.observe(dds::decode<mission::Battery>(m));
        break;
      case mission::MessageClass::kInspected:
        executive_.on_inspected(dds::decode<mission::Inspected>(m));
        break;
      case mission::MessageClass::kOperatorRequest:
        take_request(dds::decode<mission::OperatorRequest>(m));
        break;
      default:
        break;
    }
  }
  for (const mission::Message& m : input.bus) {
    if (m.cls == mission::MessageClass::kScan) take_scan(dds::decode<mission::Scan>(m));
    if (m.cls == mission::MessageClass::kSightings)
      strategy_->on_sightings(knowledge_, dds::decode<mission::Sightings>(m));
  }
}

/// Who starts away from its start has flown before, and then come down where it is (RULES
/// "Motion"): its body was in the column above, up to where its map says that it can fly, whatever
/// is said to be in between. Its map may be lost, or not know the place: up there was room for it,
/// a little at least, and from there it sees more.
void Robot::find_itself(const mission::Odometry& odometry) {
  knowledge_.observe(odometry);
  const mission::Vehicle& vehicle = knowledge_.config().vehicle;
  if (std::exchange(located_, true) || vehicle.ground) return;
  const mission::Mission& mission = knowledge_.mission();
  const Vec3& p = odometry.pose.p;
  if ((p - knowledge_.config().start.p).norm() < mission.free_ball_m) return;
  map::VoxelMap& map = knowledge_.map();
  const double voxel_m = mission.resolution_m;
  const auto above = [&](int i) -> Vec3 { return p + i * voxel_m * Vec3::UnitZ(); };
  const int highest = static_cast<int>(kThrough_m / voxel_m);
  int up = 0;
  while (up < highest && map.at(above(up)) != map::Voxel::kUnknown && !map.traversable(above(up)))
    ++up;
  if (!map.traversable(above(up))) up = static_cast<int>(kWayUp_m / voxel_m);
  for (int i = 0; i <= up; ++i) map.clear_ball(above(i), vehicle.radius_m + voxel_m / 2);
  if (!knowledge_.paths().confined(p, kWayOut_m)) return;
  const double around_m = vehicle.radius_m + mission.clearance_m + voxel_m;
  for (int i = 0; i <= up; ++i) map.suppose_free_ball(above(i), around_m);
  executive_.rise_first(above(up));  // beside the column it is only supposed to be free
}

void Robot::take_scan(const mission::Scan& scan) {
  const Stopwatch watch(planning_, mission::PlanningStep::kMap);
  std::vector<map::Sphere> mates;
  for (const auto& [id, mate] : knowledge_.teammates()) {
    const double age_s = (knowledge_.now() - mate.heard).s();
    if (age_s > kFreshMate_s) continue;
    mates.push_back({mate.beacon.pose.p + age_s * mate.beacon.velocity_mps, mate.beacon.radius_m});
  }
  map::RangeScan sweep;
  sweep.time = scan.time;
  sweep.sensor = scan.sensor;
  sweep.pitch_rad = scan.pitch_rad;
  sweep.columns = scan.columns;
  sweep.rows = scan.rows;
  sweep.hfov_rad = static_cast<double>(scan.hfov_rad);
  sweep.vfov_rad = static_cast<double>(scan.vfov_rad);
  sweep.range_m = static_cast<double>(scan.range_m);
  sweep.range_mm = scan.range_mm;
  // Where the body is there is nothing else, whatever a teammate who saw it hover took it for: its
  // own place, once occupied, would wall it in.
  knowledge_.map().insert_free_ball(scan.sensor.p, knowledge_.config().vehicle.radius_m);
  const std::vector<Vec3> unexplained = knowledge_.map().integrate(sweep, mates).unexplained;
  executive_.lookout().looked(knowledge_.now(), sweep);
  executive_.bodies().see_through(knowledge_.map(), sweep, unexplained);
  executive_.bodies().see(knowledge_.now(), unexplained);
  strategy_->on_scan(knowledge_, scan);
}

/// Only stations hear the operator; the request then spreads like any record.
void Robot::take_request(const mission::OperatorRequest& request) {
  mission::Status status;
  status.kind = mission::StatusKind::kRequest;
  status.request = request.verb;
  status.robot = request.robot;
  status.request_n = knowledge_.requests().empty() ? 1 : knowledge_.requests().rbegin()->first + 1;
  knowledge_.publish(store::RecordClass::kRequest, request_key(status.request_n), status);
}

void Robot::take_air(const mission::StepInput& input) {
  for (const mission::Message& m : input.air) {
    try {
      const mission::Envelope e = dds::peek_envelope(m.cdr);
      if (!mission::is_record(m.cls)) pace_.heard_beacon(m.cdr.size());
      if (m.cls == mission::MessageClass::kBeacon) {
        const auto heard = dds::decode<mission::Beacon>(m);
        stratum_ = std::min(stratum_, heard.stratum + 1);
        knowledge_.hear(heard);
      } else if (m.cls == mission::MessageClass::kExchangeEnd) {
        const auto end = dds::decode<mission::ExchangeEnd>(m);
        knowledge_.exchange().on_end(
            e.src, e.n, {end.receiver, end.receiver_epoch, end.digest_n, end.first_n, end.entries});
      } else if (mission::is_record(m.cls)) {
        knowledge_.receive(e.src, e.n, dds::unwrap(m));
      }
    } catch (const BadInput& bad) {
      log::warn("message refused: {}",
                bad.what());  // a stranger's or corrupt message changes nothing
    }
  }
}

mission::Envelope Robot::envelope(mission::MessageClass cls) {
  return {++sent_n_, knowledge_.self(), cls, knowledge_.now()};
}

void Robot::send_bus(Executive::Commands commands, mission::StepOutput& output) {
  if (commands.trajectory) {
    commands.trajectory->envelope = envelope(mission::MessageClass::kTrajectory);
    output.bus.push_back(dds::encode(*commands.trajectory));
    announce_ = true;
  }
  if (commands.inspect) {
    commands.inspect->envelope = envelope(mission::MessageClass::kInspect);
    output.bus.push_back(dds::encode(*commands.inspect));
  }
}

void Robot::send_record(std::uint64_t n, const store::Record& record,
                        mission::StepOutput& output) try {
  const store::RecordView view = knowledge_.store().read(record, body_);
  const mission::MessageClass cls = mission::message_class(record.header.cls);
  output.air.push_back(dds::wrap({n, knowledge_.self(), cls, knowledge_.now()}, view));
} catch (const Failure& e) {
  // As if it were lost on the way.
  log::error("a record is not sent: {}", e.what());
}

void Robot::send_air(mission::StepOutput& output) {
  const SimTime now = knowledge_.now();
  const std::size_t budget = pace_.budget(knowledge_.exchange().speakers(now));
  for (const auto& action : knowledge_.exchange().step(now, budget, [this] { return ++sent_n_; })) {
    if (action.record) {
      send_record(action.n, *action.record, output);
    } else if (action.end) {
      const mission::Envelope e{action.n, knowledge_.self(), mission::MessageClass::kExchangeEnd,
                                now};
      output.air.push_back(dds::encode(
          mission::ExchangeEnd{e, action.end->receiver, action.end->receiver_epoch,
                               action.end->digest_n, action.end->first_n, action.end->entries}));
    }
  }
  if (now >= beacon_due_ || announce_ || knowledge_.exchange().digest_due(now)) {
    output.air.push_back(dds::encode(beacon()));
    beacon_due_ = now + Duration::from_s(kBeaconPeriod_s);
    announce_ = false;
  }
  for (const mission::Message& message : output.air) pace_.sent(message.cdr.size());
}

mission::Beacon Robot::beacon() {
  const SimTime now = knowledge_.now();
  mission::Beacon b;
  b.envelope = envelope(mission::MessageClass::kBeacon);
  b.epoch = knowledge_.epoch();
  b.mission_time = now;
  b.pose = knowledge_.odometry().pose;
  b.velocity_mps = knowledge_.odometry().velocity_mps;
  b.role = knowledge_.config().role;
  b.stratum = stratum_;
  b.activity = intent_.activity;
  b.radius_m = static_cast<float>(knowledge_.config().vehicle.radius_m);
  b.battery = knowledge_.battery().charge;
  b.trajectory = executive_.announcement(now);
  if (knowledge_.exchange().digest_due(now)) {
    b.digest_n = knowledge_.exchange().digest_sent(now);
    b.digest = knowledge_.store().digest();
  }
  return b;
}

}  // namespace muster::robot
