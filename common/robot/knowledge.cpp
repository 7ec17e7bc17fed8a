#include "common/robot/knowledge.h"

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/map_block.h"
#include "common/map/block_codec.h"
#include "common/radio/pace.h"

namespace muster::robot {
namespace {

// A beacon comes every tick: five lost in a row are no accident. From 5 m a vehicle is down by
// then.
constexpr double kSilent_s = 0.5, kLanded_s = 8;
constexpr Duration kContactTimeout{
    1'000'000};                // DESIGN "The DDS layer": contact means beacons heard within 1 s
constexpr double kQueued = 8;  // so many others' records may go first, there and back

/// Where bits take time, so do digests: one that was sent before a record arrived tells nothing.
store::ExchangeConfig exchange_config(const radio::RadioConfig& radio) {
  store::ExchangeConfig config;
  const radio::Airtime air(radio);
  const double longest_s = air.of(radio::Pace(radio).record_bytes()).s();
  config.round_trip = config.round_trip + Duration::from_s(kQueued * longest_s);
  return config;
}

}  // namespace

std::uint64_t plan_key(mission::PlanKind kind) { return static_cast<std::uint64_t>(kind); }
std::uint64_t meeting_key(RobotId about, mission::MeetingKind kind) {
  return std::uint64_t{about.value} << 8 | static_cast<std::uint64_t>(kind);
}
std::uint64_t result_key(const mission::AreaRef& area) { return image_key(area, 0); }
std::uint64_t image_key(const mission::AreaRef& area, std::uint32_t part) {
  return std::uint64_t{area.author.value} << 48 | (area.key & 0xFFFFFFFFu) << 16 | part;
}
std::uint64_t request_key(std::uint64_t request_n) { return std::uint64_t{1} << 32 | request_n; }
std::uint64_t lost_key(RobotId robot) { return std::uint64_t{2} << 32 | robot.value; }

map::MapConfig map_config(const mission::Mission& mission, RobotId self) {
  const mission::Vehicle& vehicle = mission.robot(self).vehicle;
  map::MapConfig config;
  config.resolution_m = mission.resolution_m;
  config.bounds = mission.hull;
  config.body_radius_m = vehicle.radius_m;
  config.clearance_m = mission.clearance_m;
  config.ground = vehicle.ground;
  config.ride_height_m = vehicle.ride_height_m;
  return config;
}

nav::Limits limits_of(const mission::Vehicle& vehicle) {
  return {vehicle.speed_mps, vehicle.accel_mps2, vehicle.yaw_rate_radps, vehicle.ground};
}

Knowledge::Knowledge(const mission::Mission& mission, RobotId self, std::uint64_t epoch)
    : mission_(mission),
      self_(self),
      limits_(limits_of(mission.robot(self).vehicle)),
      map_(map_config(mission, self)),
      paths_(map_),
      store_(self, epoch),
      exchange_(store_, Random(mission.seed, self, "exchange"), exchange_config(mission.radio)) {
  odometry_.pose = config().start;
  map_.insert_free_ball(config().start.p, mission.free_ball_m);
}

bool Knowledge::in_contact(RobotId id) const {
  const auto it = teammates_.find(id);
  return it != teammates_.end() && now_ - it->second.heard <= kContactTimeout;
}

std::optional<RobotId> Knowledge::silent_above(double aside_m) const {
  for (const auto& [id, mate] : teammates_) {
    const Vec3 off = mate.beacon.pose.p - position();
    const double silent_s = (now_ - mate.heard).s();
    if (silent_s > kSilent_s && silent_s < kLanded_s && off.z() > 0 &&
        off.head<2>().norm() < aside_m)
      return id;
  }
  return std::nullopt;
}

std::optional<SimTime> Knowledge::last_heard(RobotId id) const {
  const auto it = teammates_.find(id);
  if (it == teammates_.end()) return std::nullopt;
  return it->second.heard;
}

bool Knowledge::exchanged(RobotId id) const {
  return in_contact(id) && exchange_.caught_up(id, now_);
}

bool Knowledge::talked(RobotId id) const {
  return in_contact(id) && exchange_.caught_up(id, now_, store::RecordClass::kStatus);
}

bool Knowledge::knows(RobotId id, store::RecordClass cls, std::uint64_t key) const {
  const store::Record* mine = store_.find(self_, cls, key);
  return mine && exchange_.known_to(id, mine->header);
}

void Knowledge::hear(const mission::Beacon& beacon) {
  teammates_[beacon.envelope.src] = {beacon, now_};
  exchange_.on_beacon(beacon.envelope.src, beacon.epoch, beacon.digest_n, beacon.digest, now_);
}

bool Knowledge::receive(RobotId from, std::uint64_t n, store::Record record) {
  const store::RecordHeader header = record.header;
  if (exchange_.on_record(from, n, std::move(record), now_) != store::Merged::kNew) return false;
  if (const store::Record* held = store_.find(header.author.robot, header.cls, header.key))
    ingest(*held);  // its bytes are in memory until they are journalled
  return true;
}

void Knowledge::restore(store::Journal& journal) {
  journal.restore_looks([&](RegionId explored, const Bytes& sightings) {
    try {
      keep_look(explored,
                dds::decode<mission::Sightings>({mission::MessageClass::kSightings, sightings}));
    } catch (const BadInput& bad) {
      log::warn("a look that was kept is of no use: {}", bad.what());
    }
  });
  looks_kept_ = !looks_.empty();
  journal.restore(store_, [&](const store::Record& record) {
    try {
      ingest(record);
    } catch (const BadInput& bad) {
      log::warn("a record that was kept is of no use: {}", bad.what());
    }
  });
  journal.restore_blocks([&](std::uint64_t, const Bytes& voxels) {
    for (const map::SaidBlock& block : map::decode_blocks(voxels)) map_.adopt_own(block);
  });
}

void Knowledge::void_older(const store::Author& author) {
  std::uint64_t& newest = newest_epoch_[author.robot];
  if (author.epoch <= newest) return;
  newest = author.epoch;
  std::erase_if(plans_, [&](const auto& e) { return e.first.first == author.robot; });
  std::erase_if(meetings_, [&](const auto& e) { return std::get<0>(e.first) == author.robot; });
  health_.erase(author.robot);
}

void Knowledge::ingest(const store::Record& record) {
  const store::RecordHeader& h = record.header;
  void_older(h.author);
  switch (h.cls) {
    case store::RecordClass::kInspection:
    case store::RecordClass::kImage:
      ingest_inspection(record);
      break;
    case store::RecordClass::kMeeting: {
      auto body = dds::decode_body<mission::Meeting>(record);
      const RobotId about = body.proposer == h.author.robot ? body.partner : body.proposer;
      const auto kind = body.kind;
      meetings_[{h.author.robot, about, kind}] = {h, std::move(body)};
      break;
    }
    case store::RecordClass::kRequest:
    case store::RecordClass::kStatus:
      ingest_status(record);
      break;
    case store::RecordClass::kPlan: {
      auto body = dds::decode_body<mission::Plan>(record);
      const auto kind = body.kind;
      plans_[{h.author.robot, kind}] = {h, std::move(body)};
      break;
    }
    case store::RecordClass::kArea: {
      const mission::AreaRef ref{h.author.robot, h.key};
      areas_[ref] = {ref, dds::decode_body<mission::Area>(record), h.stamp};
      break;
    }
    case store::RecordClass::kMap:
      ingest_map(record);
      break;
  }
}

void Knowledge::ingest_map(const store::Record& record) {
  const store::RecordHeader& h = record.header;
  std::vector<map::SaidBlock> said =
      dds::said_blocks(dds::decode_body<mission::MapBlock>(record), mission_.resolution_m);
  take_back(said, h);
  for (const map::SaidBlock& block : said) {
    if (h.author.robot != self_) {
      map_.merge(h.author.robot, block);
    } else {
      map_.told(block);
      if (h.author.epoch < epoch()) map_.adopt_own(block);
    }
  }
}

/// Leaves out of `said`, which came late, what its author has said otherwise since.
void Knowledge::take_back(std::vector<map::SaidBlock>& said, const store::RecordHeader& h) const {
  const auto& streams = store_.streams();
  Bytes buffer;
  for (auto s = streams.lower_bound({h.author.robot, h.cls, h.author.epoch});
       s != streams.end() && s->first.robot == h.author.robot && s->first.cls == h.cls; ++s) {
    const bool same_start = s->first.epoch == h.author.epoch;
    for (auto r = s->second.held.upper_bound(same_start ? h.seq : 0); r != s->second.held.end();
         ++r) {
      const auto later = dds::decode_body<mission::MapBlock>(store_.read(*r->second, buffer));
      for (const map::SaidBlock& newer : dds::said_blocks(later, mission_.resolution_m)) {
        for (map::SaidBlock& older : said) {
          if (older.key == newer.key) map::take_back(older.said, newer.said);
        }
      }
    }
  }
}

void Knowledge::ingest_inspection(const store::Record& record) {
  auto body = dds::decode_body<mission::Inspection>(record);
  const RobotId by = record.header.author.robot;
  const mission::AreaRef area = body.area;
  if (body.part > 0) {
    const auto it = results_.find(area);
    if (it != results_.end() && it->second.by == by)
      ++it->second.parts_held;
    else
      ++early_parts_[area][by];
    return;
  }
  const auto it = results_.find(area);
  // Two robots may have inspected the same area: the result whose image is whole, or else the
  // first, stands.
  if (it != results_.end() && it->second.by != by &&
      (it->second.complete() || it->second.inspection.found))
    return;
  Bytes().swap(body.payload);
  results_[area] = {std::move(body), by, 1 + early_parts_[area][by]};
}

void Knowledge::ingest_status(const store::Record& record) {
  auto body = dds::decode_body<mission::Status>(record);
  switch (body.kind) {
    case mission::StatusKind::kHealth:
      health_[record.header.author.robot] = {record.header, std::move(body)};
      break;
    case mission::StatusKind::kRequest: {
      const std::uint64_t n = body.request_n;
      requests_[n] = {record.header, std::move(body)};
      break;
    }
    case mission::StatusKind::kComplete:
      complete_ = true;
      break;
    case mission::StatusKind::kLost:
      lost_[body.robot] = record.header.stamp;
      break;
    case mission::StatusKind::kLooks: {
      const store::Author& author = record.header.author;
      const bool kept = author.robot == self_ && (looks_kept_ || author.epoch == epoch());
      if (!kept) told_looks_.insert(told_looks_.end(), body.looks.begin(), body.looks.end());
      break;
    }
  }
}

bool Knowledge::result_complete(const mission::AreaRef& area) const {
  const auto it = results_.find(area);
  return it != results_.end() && it->second.complete();
}

AreaCount Knowledge::areas_in(RegionId region) const {
  AreaCount count;
  for (const auto& [ref, known] : areas_) {
    if (known.area.region != region) continue;
    ++count.found;
    count.inspected += inspected(ref) ? 1 : 0;
  }
  return count;
}

const Stated<mission::Plan>* Knowledge::plan(RobotId author, mission::PlanKind kind) const {
  const auto it = plans_.find({author, kind});
  return it == plans_.end() ? nullptr : &it->second;
}

const Stated<mission::Meeting>* Knowledge::meeting(RobotId author, RobotId about,
                                                   mission::MeetingKind kind) const {
  const auto it = meetings_.find({author, about, kind});
  return it == meetings_.end() ? nullptr : &it->second;
}

const Stated<mission::Status>* Knowledge::health(RobotId author) const {
  const auto it = health_.find(author);
  return it == health_.end() ? nullptr : &it->second;
}

const mission::Status* Knowledge::request() const {
  for (auto it = requests_.rbegin(); it != requests_.rend(); ++it) {
    const mission::Status& s = it->second.body;
    if (s.robot == kNoRobot || s.robot == self_) return &s;
  }
  return nullptr;
}

}  // namespace muster::robot
