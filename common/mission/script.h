#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "common/core/ids.h"
#include "common/core/time.h"
#include "common/core/yaml.h"
#include "common/geometry/pose.h"

namespace muster::mission {

struct Mission;

/// Something that a mission file or `muster run --faults FILE` makes happen at a time:
///
/// | entry                                                     | what happens                     |
/// |-----------------------------------------------------------|----------------------------------|
/// | {at_s: 60, verb: kill, robot: 3}                          | its process dies                 |
/// | {at_s: 80, verb: revive, robot: 3}                        | and is started again             |
/// | {at_s: 80, verb: revive, robot: 3, journal: lost}         | and its disk had to be replaced  |
/// | {at_s: 60, verb: pause, robot: 3, for_s: 5}               | gets no ticks, says nothing      |
/// | {at_s: 60, verb: jam, center: [0, 0, 3], radius_m: 8, …}  | nobody inside hears or is heard  |
/// | {at_s: 60, verb: cut, robots: [2, 3], for_s: 60}          | these two do not hear each other |
/// | {at_s: 60, verb: loss, probability: 0.5, for_s: 60}       | messages lost, at least          |
/// | {at_s: 60, verb: mute-beacons, robot: 3}                  | from now on, of one or of all    |
/// | {at_s: 60, verb: drain, robot: 3, charge: 0.1}            | the battery's level, 0 … 1       |
/// | {at_s: 60, verb: blind, robot: 2, for_s: 30}              | the camera sees nothing          |
/// | {at_s: 60, verb: full-disk, robot: 2, for_s: 30}          | its journal cannot be written    |
/// | {at_s: 60, verb: skew, robot: 2, by_s: 60}               | its clock is wrong (OwnClock)    |
/// | {at_s: 60, verb: hold}, resume, return, land, abort       | as the operator would ask        |
/// | {verb: chaos, from_s: 60, until_s: 900, down_s: [5, 30]}  | everyone dies once, comes back   |
///
/// Without `robot` it happens to everyone (not kill and revive, which name one). Chaos is replaced
/// by kills and revivals drawn from the mission's seed: robots die one after the other in a drawn
/// order, each in its own part of the time, and never are all dead at once.
struct ScriptedEvent {
  SimTime at;
  std::string verb;
  RobotId robot = kNoRobot;  ///< kNoRobot: everyone
  RobotId other = kNoRobot;  ///< cut: from whom `robot` is
  Duration lasts{};          ///< verbs with `for_s`
  Vec3 center = Vec3::Zero();
  double radius_m = 0;
  double value = 0;           ///< loss: probability; drain: charge; skew: s
  bool journal_lost = false;  ///< revive: nothing is left of what it had kept

  bool concerns(RobotId id) const { return robot == kNoRobot || robot == id; }
  bool in_force(SimTime now) const { return at <= now && now < at + lasts; }
  /// It belongs to the first tick at or after its time.
  bool due_at(std::uint64_t k) const;
};

/// Whether something with this verb is in force for `robot`.
bool in_force(const std::vector<ScriptedEvent>& script, const char* verb, RobotId robot,
              SimTime now);

/// Whether `robot` was started again without its journal, after `after` and by `until`.
bool lost_journal(const std::vector<ScriptedEvent>& script, RobotId robot, SimTime after,
                  SimTime until);

/// The entries of a `script:`, for the fleet and seed of `mission`. Throws BadInput.
std::vector<ScriptedEvent> read_script(YamlMap& map, const Mission& mission);
/// Adds the script of a file of faults to the mission's, by time. Throws BadInput.
void add_faults(Mission& mission, const std::string& file);
void write_script(std::ostream& out, const std::vector<ScriptedEvent>& script);

}  // namespace muster::mission
