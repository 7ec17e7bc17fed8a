#pragma once

#include <string>
#include <vector>

#include "common/core/random.h"
#include "common/mission/messages.h"

/// Messages with something in every field: every sequence non-empty and of odd length, so that all
/// padding is exercised.
namespace muster::test {

using namespace mission;

class Samples {
 public:
  explicit Samples(std::uint64_t seed) : random_(seed, RobotId{7}, "samples") {}

  template <class T>
  T make();

  store::RecordHeader header(store::RecordClass cls) {
    return {{id<RobotId>(), u64()}, cls, u64(), u64(), time(), bytes()};
  }
  Envelope envelope(MessageClass cls) { return {u64(), id<RobotId>(), cls, time()}; }

 private:
  std::uint64_t u64() { return random_.next(); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(random_.next()); }
  float real() { return static_cast<float>(random_.uniform(-1000, 1000)); }
  bool flag() { return random_.chance(0.5); }
  template <class T>
  T id() {
    return T(static_cast<decltype(T{}.value)>(u32()));
  }
  template <class E>
  E choice(std::uint32_t last) {
    return static_cast<E>(random_.below(last + 1));
  }
  store::RecordClass record_class() {
    return static_cast<store::RecordClass>(1 + random_.below(store::kRecordClasses));
  }
  SimTime time() { return {static_cast<std::int64_t>(random_.below(7'200'000'000))}; }
  Vec3 vec() { return {random_.uniform(-99, 99), random_.uniform(-99, 99), random_.normal()}; }
  Pose pose() { return {vec(), random_.uniform(-3, 3)}; }
  // Announced poses are floats on the wire.
  TimedPose timed_pose() { return {time(), {Vec3(real(), real(), real()), real()}}; }
  AreaRef area() { return {id<RobotId>(), u64()}; }
  std::size_t odd() { return 1 + 2 * random_.below(5); }
  Bytes bytes() {
    Bytes b(odd());
    for (auto& x : b) x = static_cast<std::uint8_t>(u32());
    return b;
  }
  std::string text() {
    std::string s(odd(), ' ');
    for (char& c : s) c = static_cast<char>('a' + random_.below(26));
    return s;
  }
  template <class F>
  auto list(F one) {
    std::vector<decltype(one())> v;
    for (std::size_t n = odd(); n > 0; --n) v.push_back(one());
    return v;
  }
  Finding finding() { return {id<FeatureId>(), u32(), vec()}; }
  Expect expect() { return {id<RobotId>(), u32(), u32()}; }

  Random random_;
};

template <>
inline Beacon Samples::make() {
  const auto range = [&] { return SeqRange{u64(), u64()}; };
  const auto entry = [&] {
    return DigestEntry{{id<RobotId>(), u64()}, record_class(), u64(), list(range)};
  };
  return {envelope(MessageClass::kBeacon),
          u64(),
          time(),
          pose(),
          vec(),
          choice<Role>(2),
          u32(),
          choice<Activity>(10),
          real(),
          real(),
          list([&] { return timed_pose(); }),
          u64(),
          list(entry)};
}
template <>
inline MapBlock Samples::make() {
  return {real(), choice<BlockEncoding>(2), bytes()};
}
template <>
inline Area Samples::make() {
  return {vec(), pose(), vec(), real(), u32(), id<RegionId>(), u32(), u32(), u32()};
}
template <>
inline Inspection Samples::make() {
  return {area(), vec(), pose(), time(), flag(), list([&] { return finding(); }),
          u32(),  u32(), u32(),  bytes()};
}
template <>
inline Plan Samples::make() {
  const auto step = [&] {
    return PlanStep{timed_pose(), choice<PlanAction>(6), id<RobotId>(), area(), real()};
  };
  const auto allocation = [&] {
    return Allocation{id<RobotId>(), id<RobotId>(), id<RegionId>(), area()};
  };
  return {choice<PlanKind>(2), list(step), list(allocation)};
}
template <>
inline Meeting Samples::make() {
  return {choice<MeetingKind>(2),
          id<MeetingId>(),
          id<RobotId>(),
          id<RobotId>(),
          u64(),
          u64(),
          list([&] {
            return Rung{vec(), time(), time()};
          }),
          id<RegionId>()};
}
template <>
inline Status Samples::make() {
  const auto region = [&] {
    return RegionProgress{id<RegionId>(), choice<RegionState>(4), real(), real(), u32(), u32(),
                          real()};
  };
  return {choice<StatusKind>(4),
          id<RobotId>(),
          choice<RequestVerb>(5),
          u32(),
          real(),
          real(),
          list(region),
          list([&] { return pose(); }),
          text()};
}
template <>
inline ExchangeEnd Samples::make() {
  const auto entry = [&] { return EndEntry{{id<RobotId>(), u64()}, record_class(), u64(), u32()}; };
  return {envelope(MessageClass::kExchangeEnd), id<RobotId>(), u64(), u64(), u64(), list(entry)};
}
template <>
inline Odometry Samples::make() {
  return {
      envelope(MessageClass::kOdometry), time(), pose(), vec(), real(), choice<VehicleState>(4)};
}
template <>
inline Scan Samples::make() {
  const auto range = [&] { return static_cast<std::uint16_t>(u32()); };
  return {envelope(MessageClass::kScan),
          time(),
          pose(),
          real(),
          choice<SensorKind>(2),
          u32(),
          u32(),
          real(),
          real(),
          real(),
          list(range)};
}
template <>
inline Sightings Samples::make() {
  const auto sighting = [&] { return Sighting{vec(), u32(), u32(), u32()}; };
  return {envelope(MessageClass::kSightings), time(), pose(), real(), list(sighting)};
}
template <>
inline Battery Samples::make() {
  return {envelope(MessageClass::kBattery), time(), real(), real(), flag(), -1};
}
template <>
inline Inspected Samples::make() {
  return {envelope(MessageClass::kInspected), time(), u64(), choice<InspectOutcome>(3),
          list([&] { return finding(); }),    bytes()};
}
template <>
inline OperatorRequest Samples::make() {
  return {envelope(MessageClass::kOperatorRequest), choice<RequestVerb>(5), id<RobotId>()};
}
template <>
inline Trajectory Samples::make() {
  const auto state = [&] { return TimedState{time(), vec(), vec(), real()}; };
  return {envelope(MessageClass::kTrajectory), u64(), flag(), list(state)};
}
template <>
inline Inspect Samples::make() {
  return {envelope(MessageClass::kInspect), u64(), vec(), real()};
}
template <>
inline Charge Samples::make() {
  return {envelope(MessageClass::kCharge), static_cast<std::int32_t>(u32())};
}
template <>
inline Tick Samples::make() {
  return {envelope(MessageClass::kTick),
          u64(),
          time(),
          choice<TickPhase>(2),
          list([&] { return id<RobotId>(); }),
          list([&] { return expect(); }),
          text()};
}
template <>
inline Done Samples::make() {
  const auto planning = [&] { return PlanningTime{choice<PlanningStep>(7), real()}; };
  return {envelope(MessageClass::kDone),
          u64(),
          id<RobotId>(),
          u32(),
          u32(),
          u64(),
          flag(),
          choice<Activity>(10),
          real(),
          list([&] { return expect(); }),
          list(planning)};
}
template <>
inline Truth Samples::make() {
  const auto state = [&] {
    return TrueState{id<RobotId>(), choice<VehicleState>(4), pose(), vec()};
  };
  return {envelope(MessageClass::kTruth), u64(), time(), list(state)};
}

}  // namespace muster::test
