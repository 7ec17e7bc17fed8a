#include "common/mission/script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "common/core/random.h"
#include "common/mission/mission.h"
#include "common/mission/reading.h"

namespace muster::mission {
namespace {

enum class Whom { kEveryone, kOne, kAny, kPair };

/// What a verb needs to be told.
struct Verb {
  std::string_view name;
  Whom whom = Whom::kEveryone;
  bool lasts = false;
};
constexpr std::array kVerbs{Verb{"kill", Whom::kOne},
                            Verb{"revive", Whom::kOne},
                            Verb{"hold", Whom::kAny},
                            Verb{"resume", Whom::kAny},
                            Verb{"return", Whom::kAny},
                            Verb{"land", Whom::kAny},
                            Verb{"abort", Whom::kAny},
                            Verb{"mute-beacons", Whom::kAny},
                            Verb{"pause", Whom::kAny, true},
                            Verb{"jam", Whom::kEveryone, true},
                            Verb{"cut", Whom::kPair, true},
                            Verb{"loss", Whom::kEveryone, true},
                            Verb{"drain", Whom::kAny},
                            Verb{"blind", Whom::kAny, true},
                            Verb{"full-disk", Whom::kAny, true},
                            Verb{"skew", Whom::kAny}};
constexpr double kLatest_s = 1e7;  // no mission is longer; what is may not fit into microseconds
constexpr double kMostSkew_s = 3600;
constexpr const char* kChaos = "chaos";
/// Of its part of the time, the share in which a robot of a `chaos` may die.
constexpr double kDyingShare = 0.5;

const Verb& read_verb(YamlMap& map, const std::string& name) {
  const auto verb = std::ranges::find(kVerbs, name, &Verb::name);
  if (verb != kVerbs.end()) return *verb;
  std::string names;
  for (const Verb& v : kVerbs) names += fmt::format("{}, ", v.name);
  map.fail("verb", fmt::format("'{}' is not one of {}{}", name, names, kChaos));
}

RobotId known(const YamlMap& map, const char* key, std::uint32_t id, const Mission& m) {
  if (!m.has(RobotId{id})) map.fail(key, fmt::format("there is no robot {}", id));
  return RobotId{id};
}

void read_pair(YamlMap& map, const Mission& m, ScriptedEvent& e) {
  std::vector<std::uint32_t> pair;
  map.require("robots", pair);
  if (pair.size() != 2 || pair[0] == pair[1]) map.fail("robots", "two different robots, [2, 3]");
  e.robot = known(map, "robots", pair[0], m);
  e.other = known(map, "robots", pair[1], m);
}

void read_whom(YamlMap& map, Whom whom, const Mission& m, ScriptedEvent& e) {
  if (whom == Whom::kPair) return read_pair(map, m, e);
  if (whom == Whom::kEveryone || (whom == Whom::kAny && !map.has("robot"))) return;
  std::uint32_t id = 0;
  map.require("robot", id);
  e.robot = known(map, "robot", id, m);
}

double read_time(YamlMap& map, const char* key) {
  if (!map.has(key)) map.fail("", fmt::format("'{}' is missing", key));
  double s = 0;
  read_between(map, key, s, 0, kLatest_s);
  return s;
}

Duration read_lasts(YamlMap& map) {
  if (!map.has("for_s")) map.fail("", "'for_s' is missing");
  double s = 0;
  read_positive(map, "for_s", s);
  read_between(map, "for_s", s, 0, kLatest_s);
  return Duration::from_s(s);
}

void read_values(YamlMap& map, ScriptedEvent& e) {
  if (e.verb == "jam") {
    map.require("center", e.center);
    map.require("radius_m", e.radius_m);
    read_positive(map, "radius_m", e.radius_m);
  } else if (e.verb == "loss") {
    map.require("probability", e.value);
    read_between(map, "probability", e.value, 0, 1);
  } else if (e.verb == "drain") {
    map.require("charge", e.value);
    read_between(map, "charge", e.value, 0, 1);
  } else if (e.verb == "skew") {
    map.require("by_s", e.value);
    read_between(map, "by_s", e.value, -kMostSkew_s, kMostSkew_s);
  } else if (e.verb == "revive" && map.has("journal")) {
    std::string journal;
    map.require("journal", journal);
    e.journal_lost = journal == "lost";
    if (!e.journal_lost) map.fail("journal", "lost, or leave it out: then it was kept");
  }
}

ScriptedEvent read_event(YamlMap& map, const std::string& name, const Mission& m) {
  const Verb& verb = read_verb(map, name);
  ScriptedEvent e;
  e.verb = name;
  e.at = SimTime::from_s(read_time(map, "at_s"));
  read_whom(map, verb.whom, m, e);
  if (verb.lasts) e.lasts = read_lasts(map);
  read_values(map, e);
  map.finish();
  return e;
}

struct Chaos {
  double from_s = 0, until_s = 0;
  double down_low_s = 0, down_high_s = 0;
};

Chaos read_chaos(YamlMap& map, std::size_t robots) {
  Chaos c;
  c.from_s = read_time(map, "from_s");
  c.until_s = read_time(map, "until_s");
  if (c.until_s <= c.from_s) map.fail("until_s", "must be after from_s");
  std::vector<double> down;
  map.require("down_s", down);
  if (down.size() != 2 || !(down[0] > 0) || !(down[1] >= down[0]))
    map.fail("down_s", "[shortest, longest], both greater than 0");
  c.down_low_s = down[0], c.down_high_s = down[1];
  map.finish();
  // From the first death to the last.
  const double span_s = (c.until_s - c.from_s) / static_cast<double>(robots) *
                        (static_cast<double>(robots) - 1 - kDyingShare);
  if (c.down_high_s >= span_s)
    map.fail("down_s", fmt::format("must stay below {:.1f}, or all could be dead at once", span_s));
  return c;
}

/// Everyone dies once, each in its own part of the time, and comes back.
void expand(const Chaos& c, const Mission& m, std::vector<ScriptedEvent>& script) {
  Random random(m.seed, kWorldId, kChaos);
  std::vector<RobotId> order;
  for (const RobotConfig& robot : m.fleet) order.push_back(robot.id);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  const double part_s = (c.until_s - c.from_s) / static_cast<double>(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const double dies_s =
        c.from_s + part_s * (static_cast<double>(i) + kDyingShare * random.uniform());
    const double down_s = random.uniform(c.down_low_s, c.down_high_s);
    script.push_back({SimTime::from_s(dies_s), "kill", order[i]});
    script.push_back({SimTime::from_s(dies_s + down_s), "revive", order[i]});
  }
}

}  // namespace

bool ScriptedEvent::due_at(std::uint64_t k) const {
  const SimTime t = time_of_tick(k);
  return at <= t && (k == 0 || at > t - kTick);
}

bool in_force(const std::vector<ScriptedEvent>& script, const char* verb, RobotId robot,
              SimTime now) {
  return std::ranges::any_of(script, [&](const ScriptedEvent& e) {
    return e.verb == verb && e.concerns(robot) && e.in_force(now);
  });
}

bool lost_journal(const std::vector<ScriptedEvent>& script, RobotId robot, SimTime after,
                  SimTime until) {
  return std::ranges::any_of(script, [&](const ScriptedEvent& e) {
    return e.journal_lost && e.robot == robot && e.at > after && e.at <= until;
  });
}

std::vector<ScriptedEvent> read_script(YamlMap& map, const Mission& m) {
  std::vector<ScriptedEvent> script;
  for (YamlMap& item : map.list("script")) {
    std::string verb;
    item.require("verb", verb);
    if (verb == kChaos) {
      expand(read_chaos(item, m.fleet.size()), m, script);
    } else {
      script.push_back(read_event(item, verb, m));
    }
  }
  std::ranges::stable_sort(script, {}, &ScriptedEvent::at);
  return script;
}

void add_faults(Mission& mission, const std::string& file) {
  YamlMap map = YamlMap::load(file);
  if (!map.has("script")) map.fail("", "'script' is missing");
  const std::vector<ScriptedEvent> faults = read_script(map, mission);
  map.finish();
  mission.script.insert(mission.script.end(), faults.begin(), faults.end());
  std::ranges::stable_sort(mission.script, {}, &ScriptedEvent::at);
}

void write_script(std::ostream& out, const std::vector<ScriptedEvent>& script) {
  if (!script.empty()) out << "script:\n";
  for (const ScriptedEvent& e : script) {
    out << fmt::format("  - {{at_s: {}, verb: {}", e.at.decimal_s(), e.verb);
    if (e.other != kNoRobot)
      out << fmt::format(", robots: [{}, {}]", e.robot.value, e.other.value);
    else if (e.robot != kNoRobot)
      out << fmt::format(", robot: {}", e.robot.value);
    if (e.verb == "jam")
      out << fmt::format(", center: [{}, {}, {}], radius_m: {}", e.center.x(), e.center.y(),
                         e.center.z(), e.radius_m);
    if (e.verb == "loss") out << fmt::format(", probability: {}", e.value);
    if (e.verb == "skew") out << fmt::format(", by_s: {}", e.value);
    if (e.verb == "drain") out << fmt::format(", charge: {}", e.value);
    if (e.journal_lost) out << ", journal: lost";
    if (e.lasts.us > 0) out << fmt::format(", for_s: {}", e.lasts.decimal_s());
    out << "}\n";
  }
}

}  // namespace muster::mission
