#include "common/dds/retime.h"

#include "common/core/error.h"
#include "common/dds/convert.h"

namespace muster::dds {
namespace {

using mission::Message;
using mission::MessageClass;

template <class T, class Change>
void change(Message& message, const Change& how) try {
  T plain = decode<T>(message);
  how(plain);
  message = encode(plain);
} catch (const BadInput&) {
  // Refused, and said so, where it is read.
}

template <class T>
void retime_whole(Message& sample, const Retime& retime) {
  change<T>(sample, [&](T& plain) { plain.time = retime(plain.time); });
}

}  // namespace

void retime_sample(Message& sample, const Retime& retime) {
  switch (sample.cls) {
    case MessageClass::kOdometry:
      return retime_whole<mission::Odometry>(sample, retime);
    case MessageClass::kScan:
      return retime_whole<mission::Scan>(sample, retime);
    case MessageClass::kSightings:
      return retime_whole<mission::Sightings>(sample, retime);
    case MessageClass::kBattery:
      return retime_whole<mission::Battery>(sample, retime);
    case MessageClass::kInspected:
      return retime_whole<mission::Inspected>(sample, retime);
    default:
      return;
  }
}

void retime_command(Message& command, const Retime& retime) {
  if (command.cls != MessageClass::kTrajectory) return;
  change<mission::Trajectory>(command, [&](mission::Trajectory& plain) {
    for (mission::TimedState& state : plain.states) state.t = retime(state.t);
  });
}

void retime_beacon(Message& beacon, const Retime& retime) {
  if (beacon.cls != MessageClass::kBeacon) return;
  change<mission::Beacon>(beacon, [&](mission::Beacon& plain) {
    plain.mission_time = retime(plain.mission_time);
    for (mission::TimedPose& pose : plain.trajectory) pose.t = retime(pose.t);
  });
}

void set_stratum(Message& beacon, std::uint32_t stratum) {
  if (beacon.cls != MessageClass::kBeacon) return;
  change<mission::Beacon>(beacon, [&](mission::Beacon& plain) { plain.stratum = stratum; });
}

}  // namespace muster::dds
