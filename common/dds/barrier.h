#pragma once

#include <chrono>
#include <cstdint>
#include <future>
#include <map>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/dds/participant.h"
#include "common/mission/messages.h"

/// What the three sides of the lock-step share (DESIGN "Time and determinism"): who sits where,
/// which topics, how long to wait.
///
///     bus domain D (hub: world)                        air domain D+1 (hub: radio)
///     sim: tick, truth ─▶ robots, radio                up.<id>:   8 topics, robot ─▶ radio
///          done ◀─ robots, radio                       down.<id>: 8 topics, radio ─▶ robot
///     bus.<id>: samples ─▶ robot, commands ◀─ robot               (the station's ─▶ world, too)
///                                                      sim: done, robot ─▶ radio
///
/// In a star, participants that are not the hub do not see each other; that is why a robot says
/// `done` in both domains.
namespace muster::dds {

struct BarrierConfig {
  Vendor vendor = Vendor::kCyclone;
  std::uint32_t domain = 0;                  ///< of the bus; the air is domain + 1
  std::chrono::duration<double> start{120};  ///< until everyone is matched and the first tick comes
  std::chrono::duration<double> missing{
      10};  ///< nothing new for so long in the middle of a tick: the run has failed
  std::chrono::duration<double> busy{120};  ///< the longest that a robot may work on one tick
  std::chrono::duration<double> silence{
      4};  ///< a robot or the radio hears nothing from the world (which speaks every second)

  /// MUSTER_PATIENCE=<factor> in the environment makes every wait longer: for sanitizers and
  /// debuggers.
  static BarrierConfig from(Vendor vendor, std::uint32_t domain);
};

/// Participant numbers. The hub has 0; a robot has different ones in its two domains, because Fast
/// DDS knows a number only once per process; the hubs' seats in each other's domain lie behind the
/// robots', below the next domain's ports.
inline constexpr std::uint32_t kHub = 0;
inline constexpr std::uint32_t kRadioOnBus = 121;
inline constexpr std::uint32_t kWorldOnAir = 122;
/// Throws BadInput for ids that have no number left (above 59).
std::uint32_t participant_on_bus(RobotId robot);
std::uint32_t participant_on_air(RobotId robot);

/// `Done.k` of a process that is matched and waits for the first tick.
inline constexpr std::uint64_t kReady = ~std::uint64_t{0};

inline constexpr mission::MessageClass kSampleClasses[] = {
    mission::MessageClass::kOdometry, mission::MessageClass::kScan,
    mission::MessageClass::kSightings, mission::MessageClass::kBattery,
    mission::MessageClass::kInspected};
inline constexpr mission::MessageClass kCommandClasses[] = {mission::MessageClass::kTrajectory,
                                                            mission::MessageClass::kInspect,
                                                            mission::MessageClass::kCharge};

/// Which start of a robot its process is. Nobody tells the middleware that a process was killed, so
/// what listened in a former life stays matched. Hence what is meant for a robot goes to partitions
/// of its present life: it is matched when that one listens, and nothing is kept for the dead.
using Life = std::uint32_t;
inline constexpr Life kFirstLife = 1;
using Lives = std::map<RobotId, Life>;
std::string bus_partition(RobotId robot, Life life);   // "bus.<id>", then "bus.<id>.2", …
std::string down_partition(RobotId robot, Life life);  // "down.<id>", then "down.<id>.2", …

/// `Done.k` of a robot that is still working on its tick: where planning takes long (50 robots on
/// two cores), it is not missing.
inline constexpr std::uint64_t kBusy = kReady - 1;

/// "I am matched": what a process says until the clock starts, and with whom, in `deliveries`: a
/// robot its own life, the radio the lives it has opened a way to.
mission::Done ready(const Lives& lives = {});
Lives lives_in(const mission::Done& ready);
/// Was it said of the life that `robot` has now?
bool said_of(const Lives& said, RobotId robot, const Lives& now);

ParticipantConfig participant_config(const BarrierConfig& config, std::uint32_t domain,
                                     std::uint32_t participant);

/// The world asked for the run to end, on purpose or because something failed; `what()` is its
/// note.
class WorldEnded : public Failure {
 public:
  WorldEnded(const std::string& note, bool failed) : Failure(note), failed_(failed) {}
  bool failed() const { return failed_; }

 private:
  bool failed_;
};

/// One writer per topic for one partition.
class WriterSet {
 public:
  WriterSet() = default;
  template <class Classes>
  WriterSet(Participant& participant, const Classes& classes, const std::string& partition,
            const OnMatch& on_match) {
    for (mission::MessageClass cls : classes) add(participant, cls, partition, on_match);
  }
  void add(Participant& participant, mission::MessageClass cls, const std::string& partition,
           const OnMatch& on_match, Delivery delivery = Delivery::kEvery);
  /// Throws std::logic_error when the class has no writer here.
  void write(const mission::Message& message) const;
  /// Every writer has at least `readers`.
  bool matched(int readers) const;

 private:
  friend class Undertaker;
  struct Entry {
    mission::MessageClass cls;
    std::unique_ptr<Writer> writer;
  };
  std::vector<Entry> writers_;
};

/// Ends the writers to whom nobody listens any more. A writer goes only after a second when
/// something is not acknowledged (Cyclone's linger duration). Nobody else waits for that: a dozen
/// dead at once would keep the rest waiting for longer than a tick may take.
class Undertaker {
 public:
  void bury(WriterSet&& writers);

 private:
  std::vector<std::future<void>> going_;
};

/// One reader per topic for one partition (or pattern).
class ReaderSet {
 public:
  ReaderSet() = default;
  template <class Classes>
  ReaderSet(Participant& participant, const Classes& classes, const std::string& partition,
            const OnMessage& on_message, const OnMatch& on_match) {
    for (mission::MessageClass cls : classes)
      add(participant, cls, partition, on_message, on_match);
  }
  void add(Participant& participant, mission::MessageClass cls, const std::string& partition,
           const OnMessage& on_message, const OnMatch& on_match,
           Delivery delivery = Delivery::kEvery);
  bool matched(int writers) const;

 private:
  std::vector<std::unique_ptr<Reader>> readers_;
};

}  // namespace muster::dds
