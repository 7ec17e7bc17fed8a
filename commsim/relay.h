#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "common/mission/messages.h"
#include "common/mission/mission.h"
#include "common/radio/channel.h"
#include "commsim/ether.h"
#include "commsim/world/scene.h"

namespace muster::commsim {

/// The radio as a pure core: per message and receiver it decides by the mission's radio (and its
/// mesh, if it has one) on the true poses of the tick, and accounts for it in the fixed order (src,
/// n, receiver). Reads envelopes only; bytes pass untouched.
///
/// Where the air is shared, beacons go first, then everybody's first message, everybody's second …;
/// who begins changes with the tick. What takes longer than a tick to send is heard in a later one.
class Relay {
 public:
  Relay(const mission::Mission& mission, const std::shared_ptr<const world::Scene>& scene);
  /// With another idea of what stands between two places (tests).
  Relay(const mission::Mission& mission, radio::LineOfSight line_of_sight);
  Relay(const mission::Mission& mission, const radio::Obstacles& obstacles);
  ~Relay();

  struct Outcome {
    std::map<RobotId, std::vector<mission::Message>>
        deliveries;           ///< per destination, in (src, n) order, to be heard in tick k + 1
    std::uint64_t trace = 0;  ///< sends and deliveries with reasons of this tick
    std::vector<std::pair<RobotId, RobotId>> met;  ///< who met in this tick (Contacts)
  };
  /// `sent`: everything sent on air in this tick, per sender's partition; refuses (and counts)
  /// messages whose envelope is not the sender's or not of an air topic. Dead is who was set so, or
  /// whose vehicle is: it neither sends nor hears.
  Outcome step(const mission::Truth& truth,
               const std::map<RobotId, std::vector<mission::Message>>& sent);

  void set_alive(RobotId robot, bool alive);
  /// Where `robot` is is known (it is at first), or not: then it is unheard and hears nothing, for
  /// want of a `pose`.
  void set_located(RobotId robot, bool located);
  /// Robots keep their journals below `dir`, the directory of their results. Each is judged by what
  /// its robot had promised (Promises), when the robot dies and at `finish`; who was started again
  /// without its journal, by what it promised since.
  void judge_journals_in(const std::string& dir);
  /// From now on writes who heard whom to `path` (AirLog has its columns); `finish` writes the rest
  /// of it. Throws Failure.
  void log_to(const std::string& path);
  void finish();
  /// `{"air": {messages, bytes, delivered, delivered_bytes, refused, dropped: {reason: n},
  /// by_mesh, by_topic: {topic: {messages, bytes}}},
  ///   "contacts": [{"robots": [a, b], "seconds", "intervals": [[from_s, until_s], …], "meetings",
  ///   "bytes", "map_bytes", "data_seconds"}]}`,
  /// and `records_lost` of Promises, null where no journals are judged.
  /// A contact lasts from the first beacon heard, either way, until none was heard for 1 s; one
  /// after more than 30 s apart is a meeting. `bytes`: heard, both ways; `data_seconds`: of the
  /// contact, in which anything but beacons came through.
  nlohmann::json summary() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace muster::commsim
