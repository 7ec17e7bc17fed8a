#pragma once

#include <atomic>
#include <cstdint>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "common/dds/barrier.h"
#include "common/dds/inbox.h"
#include "common/mission/mission.h"
#include "commsim/pose_table.h"
#include "commsim/relay.h"
#include "commsim/world/hub_options.h"

namespace muster::commsim {

/// How the radio of a lab is asked to run. `domain`: of the poses; the radio is on the next one.
struct LabOptions : world::HubOptions {
  std::string profile = "sim-localhost";  ///< of the radio's network; poses are on this computer
  std::string network_interface;
  std::vector<std::string> peers;
};

/// The radio between real robots in a room with motion capture: real time on its own clock, poses
/// from the cameras, walls from the mission's scene.
///
///     poses, domain D, this computer          radio, domain D+1
///     sim: truth, motion capture ─▶ us        up.<id>:   8 topics, robot ─▶ us
///                                             down.<id>: 8 topics, us ─▶ robot
///
/// The motion capture says what the world says in simulation, the same message in the same
/// partition. What robots have said by a tick (0.1 s) is decided upon in it and delivered at once.
/// Nothing is repeated, as on air in the field.
class LabRadio {
 public:
  using Tell = std::function<void(const nlohmann::json&)>;

  /// `tell` hears, one object each: {"heard": id} of whoever speaks for the first time, and
  /// {"pose": id, "known": bool} of whoever is seen, or not any more.
  LabRadio(const LabOptions& options, Tell tell);

  /// Until `stop`; looked at every tick.
  void run(const std::function<bool()>& stop);
  /// As the relay's, and the mission's name and fleet.
  nlohmann::json finish();

 private:
  void take(dds::Inbox::Clock::time_point due);
  void sort_in(mission::Message&& message);
  void step(std::uint64_t k);
  void locate(mission::Truth& truth);
  void note_pose(RobotId robot, bool known);
  void write_tracks(const mission::Truth& truth);
  SimTime now() const;

  const mission::Mission mission_;
  const Tell tell_;
  Relay relay_;
  PoseTable poses_;
  std::ofstream tracks_;
  dds::Inbox inbox_;
  std::unique_ptr<dds::Participant> sim_, air_;
  dds::ReaderSet poses_reader_, up_;
  std::map<RobotId, dds::WriterSet> down_;
  dds::Inbox::Clock::time_point start_;
  std::map<RobotId, std::vector<mission::Message>> sent_;  ///< since the last tick
  std::set<RobotId> heard_, located_, missed_, strangers_;
  SimTime stepped_;
};

}  // namespace muster::commsim
