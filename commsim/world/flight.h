#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/core/hash.h"
#include "common/mission/messages.h"
#include "common/mission/mission.h"
#include "commsim/world/world.h"

namespace muster::world {

struct FlightConfig {
  std::string
      out;  ///< directory for events.jsonl, tracks.csv, features.csv; empty: none are written
  double duration_s =
      0;               ///< ends after this many simulated seconds; 0: the mission's own limit only
  bool trace = false;  ///< also trace.csv: where two runs that should be equal part ways
};

/// What one robot's process reported for a tick.
struct RobotReport {
  RobotId robot;
  std::uint64_t trace = 0;
  bool declares_complete = false;
  mission::Activity activity{};
  std::vector<mission::PlanningTime> planning;
};

/// The book kept about one run around its World, the same whether robots live in this process or
/// answer over DDS: the trace, what the referee hears of the station, who was lost, tracks and
/// events, and the decision that the run is over. Per tick k, in this order:
///
///     tick_begins(k, truth) → station_heard(deliveries of k) → robot_done(each live robot, by id)
///     → radio_done → end_reason(k)
class Flight {
 public:
  Flight(const mission::Mission& mission, World& world, const FlightConfig& config);

  void tick_begins(std::uint64_t k, const mission::Truth& truth);
  /// Messages delivered to the station, in (src, n) order; the records among them are what it
  /// knows.
  void station_heard(const std::vector<mission::Message>& messages);
  void robot_done(const RobotReport& report);
  void radio_done(std::uint64_t trace);
  /// Why the run is over after tick k, if it is. `alive`: robots that have a process, or will have
  /// one again.
  std::optional<std::string> end_reason(std::uint64_t k, std::size_t alive);

  /// A robot's process ended; `how` is for people ("killed by signal 9", "scripted"). Nothing new
  /// of one that ended again before it was back.
  void robot_lost(RobotId robot, const std::string& how);
  void robot_back(RobotId robot);
  /// The operator's request, forwarded to the station.
  void request(mission::RequestVerb verb, RobotId robot);
  void event(const nlohmann::json& event);

  std::uint64_t trace_hash() const { return trace_.value(); }
  SimTime now() const { return now_; }
  /// t_s, map_coverage, features…, robots: {id: activity}.
  nlohmann::json progress() const;
  /// Writes what is left to write and returns this run's part of summary.json.
  nlohmann::json finish(const std::string& reason);

 private:
  void note_faults(std::uint64_t k);
  void write_tracks(const mission::Truth& truth);
  void write_events();
  nlohmann::json planning_summary() const;

  const mission::Mission& mission_;
  World& world_;
  FlightConfig config_;
  Hasher trace_;
  SimTime now_;
  std::uint64_t ticks_ = 0;
  std::optional<SimTime> declared_;
  std::optional<SimTime> called_home_;  ///< everyone was asked to return, land or abort
  bool station_lost_ = false;
  std::set<RobotId> gone_;
  std::map<RobotId, mission::Activity> activity_;
  std::map<RobotId, mission::VehicleState> state_;
  std::vector<nlohmann::json> lost_;
  std::map<mission::PlanningStep, std::vector<float>> planning_;
  void fold(const char* part, std::uint32_t id, std::uint64_t trace);

  std::ofstream tracks_, events_, trace_file_;
};

const char* to_string(mission::Activity activity);
const char* to_string(mission::PlanningStep step);
/// "hold" … "abort"; nullopt for anything else.
std::optional<mission::RequestVerb> verb_from(const std::string& name);
const char* to_string(mission::RequestVerb verb);

}  // namespace muster::world
