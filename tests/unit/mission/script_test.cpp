#include "common/mission/script.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "tests/unit/mission/folder.h"

using namespace muster;
using namespace muster::mission;
using namespace muster::mission::testing;

namespace {

SimTime at(double s) { return SimTime::from_s(s); }

const ScriptedEvent& only(const Mission& m) {
  REQUIRE(m.script.size() == 1);
  return m.script[0];
}

}  // namespace

TEST_CASE("each fault is told whom it hits, how hard and for how long") {
  const Folder folder;
  const auto read = [&](const std::string& entry) {
    return folder.load(kGood + "script: [{at_s: 5, " + entry + "}]\n");
  };
  const Mission jam = read("verb: jam, center: [1, 2, 3], radius_m: 4, for_s: 6");
  CHECK(only(jam).center == Vec3(1, 2, 3));
  CHECK(only(jam).radius_m == 4);
  CHECK(only(jam).lasts == Duration::from_s(6));
  const Mission cut = read("verb: cut, robots: [3, 2], for_s: 6");
  CHECK(only(cut).robot == RobotId{3});
  CHECK(only(cut).other == RobotId{2});
  CHECK(only(read("verb: loss, probability: 0.4, for_s: 6")).value == 0.4);
  CHECK(only(read("verb: drain, robot: 3, charge: 0.2")).value == 0.2);
  CHECK(only(read("verb: skew, robot: 3, by_s: -60")).value == -60);
  CHECK(only(read("verb: blind, for_s: 6")).robot == kNoRobot);
  CHECK(only(read("verb: revive, robot: 3, journal: lost")).journal_lost);
  CHECK_FALSE(only(read("verb: revive, robot: 3")).journal_lost);
  const Mission pause = read("verb: pause, robot: 2, for_s: 0.5");
  CHECK_FALSE(in_force(pause.script, "pause", RobotId{2}, at(4.9)));
  CHECK(in_force(pause.script, "pause", RobotId{2}, at(5)));
  CHECK(in_force(pause.script, "pause", RobotId{2}, at(5.4)));
  CHECK_FALSE(in_force(pause.script, "pause", RobotId{2}, at(5.5)));
  CHECK_FALSE(in_force(pause.script, "pause", RobotId{3}, at(5)));
  CHECK_FALSE(in_force(pause.script, "blind", RobotId{2}, at(5)));
}

TEST_CASE("what a fault lacks or has too much of is told in one line") {
  const Folder folder;
  const auto [entry, complaint] = GENERATE(table<std::string, std::string>({
      {"at_s: 5, verb: explode",
       ".verb: 'explode' is not one of kill, revive, hold, resume, return, land, abort, "
       "mute-beacons, pause, jam, cut, loss, drain, blind, full-disk, skew, chaos"},
      {"verb: kill, robot: 3", ": 'at_s' is missing"},
      {"at_s: 5, verb: pause, robot: 3", ": 'for_s' is missing"},
      {"at_s: 5, verb: pause, robot: 3, for_s: 0", ".for_s: must be greater than 0"},
      {"at_s: 1e300, verb: kill, robot: 3", ".at_s: must be between 0 and 10000000"},
      {"at_s: 5, verb: pause, robot: 3, for_s: 1e300", ".for_s: must be between 0 and 10000000"},
      {"at_s: 5, verb: cut, robots: [2, 2], for_s: 1", ".robots: two different robots, [2, 3]"},
      {"at_s: 5, verb: cut, robots: [2, 9], for_s: 1", ".robots: there is no robot 9"},
      {"at_s: 5, verb: jam, center: [0, 0, 0], for_s: 1", ": 'radius_m' is missing"},
      {"at_s: 5, verb: loss, probability: 1.5, for_s: 1", ".probability: must be between 0 and 1"},
      {"at_s: 5, verb: drain, charge: -1", ".charge: must be between 0 and 1"},
      {"at_s: 5, verb: skew, by_s: 9999", ".by_s: must be between -3600 and 3600"},
      {"at_s: 5, verb: revive, robot: 3, journal: torn",
       ".journal: lost, or leave it out: then it was kept"},
      {"at_s: 5, verb: kill, robot: 3, journal: lost",
       ".journal: unknown key; known here: at_s, robot, verb"},
      {"at_s: 5, verb: loss, probability: 0.5, for_s: 1, robot: 3",
       ".robot: unknown key; known here: at_s, for_s, probability, verb"},
      {"verb: chaos, from_s: 9, until_s: 9, down_s: [1, 2]", ".until_s: must be after from_s"},
      {"verb: chaos, from_s: 0, until_s: 100, down_s: [3]",
       ".down_s: [shortest, longest], both greater than 0"},
      {"verb: chaos, from_s: 0, until_s: 100, down_s: [3, 63]",
       ".down_s: must stay below 62.5, or all could be dead at once"},
  }));
  CHECK(folder.complaint(kGood + "script: [{" + entry + "}]\n") ==
        "m.yaml:11: script[0]" + complaint);
}

TEST_CASE("in a chaos everyone dies once and comes back, never all at once, by the seed") {
  const Folder folder;
  const std::string text =
      kGood + "script: [{verb: chaos, from_s: 100, until_s: 500, down_s: [20, 240]}]\n";
  std::set<std::int64_t> instants;
  for (int seed = 1; seed <= 50; ++seed) {
    const Mission m = folder.load(text, {"seed=" + std::to_string(seed)});
    REQUIRE(m.script.size() == 8);
    std::set<RobotId> dead, died;
    SimTime before;
    for (const ScriptedEvent& e : m.script) {
      CHECK(e.at >= before);
      before = e.at;
      const bool kill = e.verb == "kill";
      CHECK((kill ? dead.insert(e.robot).second : dead.erase(e.robot) == 1));
      if (kill) CHECK(died.insert(e.robot).second);
      if (kill) CHECK((e.at >= at(100) && e.at <= at(500)));
      CHECK(dead.size() < m.fleet.size());
    }
    CHECK(dead.empty());
    CHECK(died.size() == m.fleet.size());
    instants.insert(m.script[0].at.us);
  }
  CHECK(instants.size() == 50);
  CHECK(folder.load(text).to_yaml() == folder.load(text).to_yaml());
}

TEST_CASE("faults of a file join the mission's own in the order of time") {
  const Folder folder;
  const std::string text = kGood + "script: [{at_s: 60, verb: kill, robot: 3}]\n";
  const Mission m = folder.load_with(text,
                                     "script:\n"
                                     "  - {at_s: 70, verb: revive, robot: 3}\n"
                                     "  - {at_s: 50, verb: blind, robot: 2, for_s: 1}\n");
  REQUIRE(m.script.size() == 3);
  CHECK(m.script[0].verb == "blind");
  CHECK(m.script[1].verb == "kill");
  CHECK(m.script[2].verb == "revive");
  CHECK(m.without_script().script.empty());
  CHECK(folder.complaint_with(text, "script: [{at_s: 1, verb: kill, robot: 9}]\n") ==
        "f.yaml:1: script[0].robot: there is no robot 9");
  CHECK(folder.complaint_with(text, "skript: []\n") == "f.yaml:1: 'script' is missing");
  CHECK(folder.complaint_with(text, "script: []\nfleet: []\n") ==
        "f.yaml:2: fleet: unknown key; known here: script");
}

TEST_CASE("every kind of fault reads back from the effective mission as itself") {
  const Folder folder;
  const Mission m =
      folder.load(kGood +
                  "script:\n"
                  "  - {at_s: 0.3, verb: jam, center: [1, -2, 3.3], radius_m: 4, for_s: 6.1}\n"
                  "  - {at_s: 1, verb: cut, robots: [3, 2], for_s: 6}\n"
                  "  - {at_s: 2, verb: loss, probability: 0.15, for_s: 6}\n"
                  "  - {at_s: 3, verb: drain, charge: 0}\n"
                  "  - {at_s: 4, verb: full-disk, robot: 2, for_s: 6}\n"
                  "  - {at_s: 4.5, verb: skew, robot: 2, by_s: -60}\n"
                  "  - {at_s: 4.7, verb: revive, robot: 2, journal: lost}\n"
                  "  - {verb: chaos, from_s: 5, until_s: 50, down_s: [1, 2]}\n");
  CHECK(m.script.size() == 15);
  const std::string text = m.to_yaml();
  CHECK(folder.load(text).to_yaml() == text);
}
