#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/dds/convert.h"
#include "common/map/voxel_map.h"
#include "common/mission/mission.h"
#include "common/nav/limits.h"
#include "common/nav/path_finder.h"
#include "common/store/exchange.h"
#include "common/store/journal.h"
#include "common/store/record_store.h"

namespace muster::robot {

struct Teammate {
  mission::Beacon beacon;
  SimTime heard;
};

/// An area of interest and what became of it, as far as this robot knows.
struct AreaKnown {
  mission::AreaRef ref;
  mission::Area area;
  SimTime stamp;
};

/// The result of inspecting one area: the statement (part 0) and how much of its image has arrived.
struct ResultKnown {
  mission::Inspection inspection;
  RobotId by;
  std::uint32_t parts_held = 0;
  bool complete() const { return parts_held >= inspection.parts; }
};

/// Areas, as far as this robot knows.
struct AreaCount {
  std::uint32_t found = 0;
  std::uint32_t inspected = 0;  ///< of these: a result is known, whole or not
};

/// One look of this robot's feature detector, also when it saw nothing.
struct Look {
  RegionId explored;  ///< on whose behalf; kNoRegion: nobody's, and nobody took what it sighted
  mission::Sightings sightings;
};

/// A record's body beside its header, for bodies of which only the newest counts.
template <class Body>
struct Stated {
  store::RecordHeader header;
  Body body;
};

/// Everything one robot knows: its mission file, its own sensors, and what the radio brought.
/// Strategies read it; only the robot's own platform writes to it. Nothing here comes from anywhere
/// else (RULES "What a robot may know").
class Knowledge {
 public:
  Knowledge(const mission::Mission& mission, RobotId self, std::uint64_t epoch);

  // ---- who and what I am
  const mission::Mission& mission() const { return mission_; }
  RobotId self() const { return self_; }
  const mission::RobotConfig& config() const { return mission_.robot(self_); }
  const nav::Limits& limits() const { return limits_; }
  /// Of what it writes now; may rise (RecordStore).
  std::uint64_t epoch() const { return store_.epoch(); }

  SimTime now() const { return now_; }
  /// What has to be past on everybody's clock is past only before this.
  SimTime surely_past() const { return now_ - clock_bound_; }
  /// The first tick of this process: what somebody did not do before, it could not have seen.
  SimTime started() const { return started_.value_or(now_); }
  const mission::Odometry& odometry() const { return odometry_; }
  const Vec3& position() const { return odometry_.pose.p; }
  const mission::Battery& battery() const { return battery_; }

  map::VoxelMap& map() { return map_; }
  const map::VoxelMap& map() const { return map_; }
  nav::PathFinder& paths() { return paths_; }
  store::RecordStore& store() { return store_; }
  const store::RecordStore& store() const { return store_; }
  store::Exchange& exchange() { return exchange_; }
  const store::Exchange& exchange() const { return exchange_; }

  /// All looks so far, in order; those of earlier starts, too, as far as the journal kept them.
  const std::vector<Look>& looks() const { return looks_; }
  /// Whence the others looked, as far as they said; this robot as well before it lost its journal.
  const std::vector<Pose>& told_looks() const { return told_looks_; }

  // ---- teammates
  const std::map<RobotId, Teammate>& teammates() const { return teammates_; }
  /// A beacon was heard within 1 s: contact is physical (DESIGN "Meetings").
  bool in_contact(RobotId id) const;
  std::optional<SimTime> last_heard(RobotId id) const;
  /// Who was last heard straight above, within `aside_m`, and fell silent: a vehicle whose process
  /// died stops and lands on whatever is below (RULES "Motion").
  std::optional<RobotId> silent_above(double aside_m) const;
  /// In contact, and neither side has anything left that the other lacks, as far as known.
  bool exchanged(RobotId id) const;
  /// As `exchanged`, without waiting for map and images.
  bool talked(RobotId id) const;
  /// By its latest digest, `id` has my newest record of this class and key.
  bool knows(RobotId id, store::RecordClass cls, std::uint64_t key) const;

  // ---- records, decoded
  const std::map<mission::AreaRef, AreaKnown>& areas() const { return areas_; }
  const std::map<mission::AreaRef, ResultKnown>& results() const { return results_; }
  bool inspected(const mission::AreaRef& area) const { return results_.contains(area); }
  /// Its result is here, image and all.
  bool result_complete(const mission::AreaRef& area) const;
  AreaCount areas_in(RegionId region) const;
  const Stated<mission::Plan>* plan(RobotId author, mission::PlanKind kind) const;
  const Stated<mission::Meeting>* meeting(RobotId author, RobotId about,
                                          mission::MeetingKind kind) const;
  const Stated<mission::Status>* health(RobotId author) const;
  /// The operator's newest word that concerns me.
  const mission::Status* request() const;
  const std::map<std::uint64_t, Stated<mission::Status>>& requests() const { return requests_; }
  bool declared_complete() const { return complete_; }
  const std::map<RobotId, SimTime>& declared_lost() const { return lost_; }

  // ---- writing (platform and the owner's strategy)
  void begin(SimTime now, Duration clock_bound = {}) {
    if (!started_) started_ = now;
    now_ = now;
    clock_bound_ = clock_bound;
  }
  /// Takes up what an earlier start of this robot kept. Before the first tick.
  void restore(store::Journal& journal);
  void observe(const mission::Odometry& odometry) { odometry_ = odometry; }
  void observe(const mission::Battery& battery) { battery_ = battery; }
  /// Nothing that is told to anybody: for the strategy, and its next start.
  void keep_look(RegionId explored, const mission::Sightings& sightings) {
    looks_.push_back({explored, sightings});
  }
  void hear(const mission::Beacon& beacon);
  /// Merges a record that arrived in envelope `n` of `from`; true when it was new.
  bool receive(RobotId from, std::uint64_t n, store::Record record);
  /// Writes a record of my own, newest version of (cls, key).
  template <dds::RecordBody Body>
  void publish(store::RecordClass cls, std::uint64_t key, const Body& body) {
    const store::RecordHeader header = store_.next_header(cls, key, now_);
    store::Record record = dds::encode_record(header, body);
    ingest(record);
    store_.insert_own(std::move(record));
  }

 private:
  void ingest(const store::Record& record);
  void ingest_inspection(const store::Record& record);
  void ingest_map(const store::Record& record);
  void take_back(std::vector<map::SaidBlock>& said, const store::RecordHeader& h) const;
  void ingest_status(const store::Record& record);
  void void_older(const store::Author& author);

  mission::Mission mission_;
  RobotId self_;
  nav::Limits limits_;
  SimTime now_;
  Duration clock_bound_;
  std::optional<SimTime> started_;
  mission::Odometry odometry_;
  mission::Battery battery_;
  std::vector<Look> looks_;
  std::vector<Pose> told_looks_;
  bool looks_kept_ = false;  // the journal has those that this robot told
  map::VoxelMap map_;
  nav::PathFinder paths_;
  store::RecordStore store_;
  store::Exchange exchange_;
  std::map<RobotId, Teammate> teammates_;

  std::map<mission::AreaRef, AreaKnown> areas_;
  std::map<mission::AreaRef, ResultKnown> results_;
  std::map<mission::AreaRef, std::map<RobotId, std::uint32_t>>
      early_parts_;  // image parts that came before their statement
  std::map<std::pair<RobotId, mission::PlanKind>, Stated<mission::Plan>> plans_;
  std::map<std::tuple<RobotId, RobotId, mission::MeetingKind>, Stated<mission::Meeting>> meetings_;
  std::map<RobotId, Stated<mission::Status>> health_;
  std::map<std::uint64_t, Stated<mission::Status>> requests_;  // by the operator's count
  std::map<RobotId, SimTime> lost_;
  std::map<RobotId, std::uint64_t> newest_epoch_;
  bool complete_ = false;
};

// Keys of records, one rule per class. The author is not part of a key.
std::uint64_t plan_key(mission::PlanKind kind);
std::uint64_t meeting_key(RobotId about, mission::MeetingKind kind);
std::uint64_t result_key(const mission::AreaRef& area);
std::uint64_t image_key(const mission::AreaRef& area, std::uint32_t part);
std::uint64_t request_key(std::uint64_t request_n);
std::uint64_t lost_key(RobotId robot);
inline constexpr std::uint64_t kHealthKey = 0;
inline constexpr std::uint64_t kCompleteKey = 1;

// Lines of the station's assignment that name no robot are about their region.
inline bool says_done(const mission::Allocation& line) {
  return line.robot == kNoRobot && line.leader == kNoRobot;
}
/// By `line.leader`; the thorough round is to follow, or under way.
inline bool says_surveyed(const mission::Allocation& line) {
  return line.robot == kNoRobot && line.leader != kNoRobot;
}

map::MapConfig map_config(const mission::Mission& mission, RobotId self);
nav::Limits limits_of(const mission::Vehicle& vehicle);

}  // namespace muster::robot
