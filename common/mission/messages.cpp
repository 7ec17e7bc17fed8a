#include "common/mission/messages.h"

#include "common/core/error.h"

namespace muster::mission {
namespace {

struct Name {
  MessageClass cls;
  const char* topic;
  const char* type;
};

constexpr Name kNames[] = {
    {MessageClass::kBeacon, "beacon", "muster::air::Beacon"},
    {MessageClass::kMapBlock, "map_block", "muster::air::MapBlock"},
    {MessageClass::kArea, "area", "muster::air::Area"},
    {MessageClass::kInspection, "inspection", "muster::air::Inspection"},
    {MessageClass::kPlan, "plan", "muster::air::Plan"},
    {MessageClass::kMeeting, "meeting", "muster::air::Meeting"},
    {MessageClass::kStatus, "status", "muster::air::Status"},
    {MessageClass::kExchangeEnd, "exchange_end", "muster::air::ExchangeEnd"},
    {MessageClass::kOdometry, "odometry", "muster::bus::Odometry"},
    {MessageClass::kScan, "scan", "muster::bus::Scan"},
    {MessageClass::kSightings, "sightings", "muster::bus::Sightings"},
    {MessageClass::kBattery, "battery", "muster::bus::Battery"},
    {MessageClass::kInspected, "inspected", "muster::bus::Inspected"},
    {MessageClass::kOperatorRequest, "operator_request", "muster::bus::OperatorRequest"},
    {MessageClass::kTrajectory, "trajectory", "muster::bus::Trajectory"},
    {MessageClass::kInspect, "inspect", "muster::bus::Inspect"},
    {MessageClass::kCharge, "charge", "muster::bus::Charge"},
    {MessageClass::kTick, "tick", "muster::sim::Tick"},
    {MessageClass::kDone, "done", "muster::sim::Done"},
    {MessageClass::kTruth, "truth", "muster::sim::Truth"},
};

const Name& name_of(MessageClass c) {
  for (const Name& n : kNames) {
    if (n.cls == c) return n;
  }
  throw BadInput("message class " + std::to_string(static_cast<std::uint32_t>(c)) +
                 " is not one of ours");
}

}  // namespace

const char* topic_name(MessageClass c) { return name_of(c).topic; }
const char* type_name(MessageClass c) { return name_of(c).type; }

const char* role_name(Role role) {
  switch (role) {
    case Role::kStation:
      return "station";
    case Role::kExplorer:
      return "explorer";
    case Role::kInspector:
      return "inspector";
  }
  throw BadInput("role " + std::to_string(static_cast<std::uint32_t>(role)) +
                 " is not one of ours");
}

MessageClass message_class(store::RecordClass cls) {
  switch (cls) {
    case store::RecordClass::kInspection:
    case store::RecordClass::kImage:
      return MessageClass::kInspection;
    case store::RecordClass::kMeeting:
      return MessageClass::kMeeting;
    case store::RecordClass::kRequest:
    case store::RecordClass::kStatus:
      return MessageClass::kStatus;
    case store::RecordClass::kPlan:
      return MessageClass::kPlan;
    case store::RecordClass::kArea:
      return MessageClass::kArea;
    case store::RecordClass::kMap:
      return MessageClass::kMapBlock;
  }
  throw BadInput("record class " + std::to_string(static_cast<std::uint32_t>(cls)) +
                 " is not one of ours");
}

}  // namespace muster::mission
