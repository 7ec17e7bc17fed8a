#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/core/bytes.h"
#include "common/core/ids.h"
#include "common/core/time.h"
#include "common/geometry/pose.h"
#include "common/store/digest.h"
#include "common/store/record.h"

/// Every message of idl/ as a plain struct, field by field in the IDL's order and meaning;
/// `common/dds/convert.h` turns them into CDR and back. Units and frames are the IDL's. Times are
/// SimTime here and seconds (`…_s`) on the wire.
namespace muster::mission {

/// What a message is, in the envelope's `cls`; also names its topic (see `topic_name`).
enum class MessageClass : std::uint32_t {
  // air
  kBeacon = 1,
  kMapBlock = 2,
  kArea = 3,
  kInspection = 4,
  kPlan = 5,
  kMeeting = 6,
  kStatus = 7,
  kExchangeEnd = 8,
  // bus
  kOdometry = 16,
  kScan = 17,
  kSightings = 18,
  kBattery = 19,
  kInspected = 20,
  kOperatorRequest = 21,
  kTrajectory = 22,
  kInspect = 23,
  kCharge = 24,
  // sim
  kTick = 32,
  kDone = 33,
  kTruth = 34,
};
inline constexpr MessageClass kAirClasses[] = {MessageClass::kBeacon, MessageClass::kMapBlock,
                                               MessageClass::kArea,   MessageClass::kInspection,
                                               MessageClass::kPlan,   MessageClass::kMeeting,
                                               MessageClass::kStatus, MessageClass::kExchangeEnd};
inline constexpr bool is_air(MessageClass c) {
  return c >= MessageClass::kBeacon && c <= MessageClass::kExchangeEnd;
}
inline constexpr bool is_record(MessageClass c) {
  return c >= MessageClass::kMapBlock && c <= MessageClass::kStatus;
}
/// The air topic that carries records of this class.
MessageClass message_class(store::RecordClass cls);
/// "beacon", "map_block", …: the DDS topic name, without "::".
const char* topic_name(MessageClass c);
/// "muster::air::Beacon", …: the DDS type name.
const char* type_name(MessageClass c);

struct Envelope {
  std::uint64_t n = 0;
  RobotId src;
  MessageClass cls{};
  SimTime sent;
};

/// One message as it travels: CDR with its 4 bytes of encapsulation, envelope first.
struct Message {
  MessageClass cls{};
  Bytes cdr;
};

struct TimedPose {
  SimTime t;
  Pose pose;
};

enum class Role : std::uint32_t { kStation = 0, kExplorer = 1, kInspector = 2 };
/// "station", "explorer", "inspector": as in the mission file.
const char* role_name(Role role);
/// What a robot says it is doing; for people and for teammates' courtesy, never for results.
enum class Activity : std::uint32_t {
  kIdle = 0,
  kExploring = 1,
  kTravelling = 2,
  kWaiting = 3,
  kMeeting = 4,
  kInspecting = 5,
  kCharging = 6,
  kHolding = 7,
  kReturning = 8,
  kLanding = 9,
  kLanded = 10,
};

// ---- air

using store::DigestEntry;
using store::SeqRange;
struct Beacon {
  Envelope envelope;
  std::uint64_t epoch = 0;
  SimTime mission_time;
  Pose pose;
  Vec3 velocity_mps = Vec3::Zero();
  Role role{};
  std::uint32_t stratum = 0;
  Activity activity{};
  float radius_m = 0;
  float battery = 1;
  std::vector<TimedPose> trajectory;
  std::uint64_t digest_n = 0;
  std::vector<DigestEntry> digest;
};

/// 0 and 1 were whole blocks of 2 bits a voxel.
enum class BlockEncoding : std::uint32_t { kArithmetic = 2 };
/// Words on some blocks; common/dds/map_block.h makes and reads them.
struct MapBlock {
  float resolution_m = 0.2f;
  BlockEncoding encoding{};
  Bytes blocks;
};
struct Area {
  Vec3 position = Vec3::Zero();
  Pose sighted_from;
  Vec3 normal = Vec3::Zero();
  float sigma_m = 0;
  std::uint32_t unexplained = 0;  ///< sightings of it, without those that a finding explains
  RegionId region = kNoRegion;
  std::uint32_t feature_type = 0, skill = 0, priority = 0;
};
/// Names an area across the fleet: the record's author (any epoch) and key.
struct AreaRef {
  RobotId author = kNoRobot;
  std::uint64_t key = 0;
  auto operator<=>(const AreaRef&) const = default;
};
struct Finding {
  FeatureId feature;
  std::uint32_t feature_type = 0;
  Vec3 position = Vec3::Zero();
};
struct Inspection {
  AreaRef area;
  Vec3 area_position = Vec3::Zero();
  Pose pose;
  SimTime done;
  bool found = false;
  std::vector<Finding> findings;
  std::uint32_t part = 0, parts = 1, payload_bytes = 0;
  Bytes payload;
};

enum class PlanKind : std::uint32_t {
  kRoute = 0,
  kAllocation = 1,
  kAssignment = 2
};  // own route; explorer → inspectors; station → explorers
enum class PlanAction : std::uint32_t {
  kGo = 0,
  kExplore = 1,
  kInspect = 2,
  kMeet = 3,
  kWait = 4,
  kCharge = 5,
  kLand = 6
};
struct PlanStep {
  TimedPose at;
  PlanAction action{};
  RobotId robot = kNoRobot;
  AreaRef area;
  float duration_s = 0;
};
struct Allocation {
  RobotId robot = kNoRobot, leader = kNoRobot;
  RegionId region = kNoRegion;
  AreaRef area;
};
struct Plan {
  PlanKind kind{};
  std::vector<PlanStep> steps;
  std::vector<Allocation> allocations;
};

enum class MeetingKind : std::uint32_t { kProposal = 0, kAcknowledgement = 1, kCancel = 2 };
struct Rung {
  Vec3 place = Vec3::Zero();
  SimTime from, until;
};
struct Meeting {
  MeetingKind kind{};
  MeetingId meeting;
  RobotId proposer = kNoRobot, partner = kNoRobot;
  std::uint64_t ack_epoch = 0, ack_seq = 0;
  std::vector<Rung> ladder;
  RegionId region = kNoRegion;
};

/// Surveyed: everything has been looked at once, and what was found is inspected and here; a
/// thorough round is to follow.
enum class RegionState : std::uint32_t {
  kPending = 0,
  kAssigned = 1,
  kExplored = 2,
  kSurveyed = 3,
  kDone = 4
};
struct RegionProgress {
  RegionId region;
  RegionState state{};
  float explored_m3 = 0, volume_m3 = 0;
  std::uint32_t areas_found = 0, areas_inspected = 0;
  float eta_s = -1;
};
enum class StatusKind : std::uint32_t {
  kHealth = 0,
  kRequest = 1,
  kComplete = 2,
  kLost = 3,
  kLooks = 4
};
enum class RequestVerb : std::uint32_t {
  kNone = 0,
  kHold = 1,
  kResume = 2,
  kReturn = 3,
  kLand = 4,
  kAbort = 5
};
struct Status {
  StatusKind kind{};
  RobotId robot = kNoRobot;
  RequestVerb request{};
  std::uint64_t request_n = 0;
  float battery = 1, energy_mah = 0;
  std::vector<RegionProgress> regions;
  std::vector<Pose> looks;  ///< kLooks: whence the author's detector looked
  std::string note;
};

using store::EndEntry;
struct ExchangeEnd {
  Envelope envelope;
  RobotId receiver;
  std::uint64_t receiver_epoch = 0, digest_n = 0, first_n = 0;
  std::vector<EndEntry> entries;
};

// ---- bus

enum class VehicleState : std::uint32_t {
  kReady = 0,
  kMoving = 1,
  kLanding = 2,
  kLanded = 3,
  kDead = 4
};
struct Odometry {
  Envelope envelope;
  SimTime time;
  Pose pose;
  Vec3 velocity_mps = Vec3::Zero();
  double yaw_rate_radps = 0;
  VehicleState state{};
};

enum class SensorKind : std::uint32_t { kDepthCamera = 0, kLidar2d = 1, kLidar3d = 2 };
inline constexpr std::uint16_t kNoReturn = 0;           ///< free as far as the sensor reaches
inline constexpr std::uint16_t kNoMeasurement = 65535;  ///< says nothing
struct Scan {
  Envelope envelope;
  SimTime time;
  Pose sensor;
  double pitch_rad = 0;
  SensorKind kind{};
  std::uint32_t columns = 0, rows = 0;
  float hfov_rad = 0, vfov_rad = 0, range_m = 0;
  std::vector<std::uint16_t> range_mm;  ///< rows × columns; ray (r, c) at azimuth hfov·(½ −
                                        ///< (c+½)/columns), elevation vfov·((r+½)/rows − ½)
};

struct Sighting {
  Vec3 position = Vec3::Zero();
  std::uint32_t feature_type = 0, priority = 0, skill = 0;
};
struct Sightings {
  Envelope envelope;
  SimTime time;
  Pose sensor;
  double pitch_rad = 0;
  std::vector<Sighting> seen;
};

struct Battery {
  Envelope envelope;
  SimTime time;
  float charge = 1, capacity_mah = 0;
  bool charging = false;
  std::int32_t station = -1;
};

enum class InspectOutcome : std::uint32_t {
  kFound = 0,
  kEmpty = 1,
  kRefusedView = 2,  ///< the area was out of view, range, line of sight or incidence, or the camera
                     ///< moved too fast, at every instant asked for
  kCancelled = 3,
};
struct Inspected {
  Envelope envelope;
  SimTime time;
  std::uint64_t request = 0;
  InspectOutcome outcome{};
  std::vector<Finding> found;
  Bytes payload;
};

struct OperatorRequest {
  Envelope envelope;
  RequestVerb verb{};
  RobotId robot = kNoRobot;
};

struct TimedState {
  SimTime t;
  Vec3 p = Vec3::Zero(), v_mps = Vec3::Zero();
  double yaw_rad = 0;
};
struct Trajectory {
  Envelope envelope;
  std::uint64_t id = 0;
  bool land = false;
  std::vector<TimedState> states;
};
struct Inspect {
  Envelope envelope;
  std::uint64_t request = 0;
  Vec3 area = Vec3::Zero();
  double hold_s = 0;
};
struct Charge {
  Envelope envelope;
  std::int32_t station = -1;
};

// ---- sim

enum class TickPhase : std::uint32_t { kRun = 0, kEnd = 1, kFailed = 2 };
struct Expect {
  RobotId process;
  std::uint32_t bus = 0, air = 0;
};
struct Tick {
  Envelope envelope;
  std::uint64_t k = 0;
  SimTime time;
  TickPhase phase{};
  std::vector<RobotId> alive;
  std::vector<Expect> expect;
  std::string note;
};
enum class PlanningStep : std::uint32_t {
  kExplore = 0,  // FF3E and its like
  kPath = 1,
  kMap = 2,
  kFrontier = 3,
  kAllocate = 4 /* SOEI and its like */,
  kTour = 5 /* station's meetings */,
  kPredict = 6,
  kAssign = 7,
};
struct PlanningTime {
  PlanningStep step{};
  float wall_ms = 0;
};
struct Done {
  Envelope envelope;
  std::uint64_t k = 0;
  RobotId process;
  std::uint32_t sent_air = 0, sent_bus = 0;
  std::uint64_t trace = 0;
  bool declares_complete = false;
  Activity activity{};
  float cpu_ms = 0;
  std::vector<Expect> deliveries;
  std::vector<PlanningTime> planning;
};
struct TrueState {
  RobotId robot;
  VehicleState state{};
  Pose pose;
  Vec3 velocity_mps = Vec3::Zero();
};
struct Truth {
  Envelope envelope;
  std::uint64_t k = 0;
  SimTime time;
  std::vector<TrueState> robots;
};

}  // namespace muster::mission
