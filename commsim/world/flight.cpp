#include "commsim/world/flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/core/error.h"
#include "common/dds/convert.h"
#include "commsim/world/tracks.h"

namespace muster::world {
namespace {

using mission::Activity;
using mission::PlanningStep;
using mission::RequestVerb;

constexpr std::array kActivities = {"idle",      "exploring",  "travelling", "waiting",
                                    "meeting",   "inspecting", "charging",   "holding",
                                    "returning", "landing",    "landed"};
constexpr std::array kSteps = {"explore",  "path", "map",     "frontier",
                               "allocate", "tour", "predict", "assign"};
constexpr std::array kVerbs = {"none", "hold", "resume", "return", "land", "abort"};

template <std::size_t N, class E>
const char* name_of(const std::array<const char*, N>& names, E value) {
  const auto i = static_cast<std::size_t>(value);
  return i < N ? names[i] : "unknown";
}

/// After the station has declared the mission complete, robots get this long to come home.
constexpr double kHomecoming_s = 300;
/// A call home is only judged by "all have landed" after they had the time to hear of it (at t = 0
/// all stand on the ground).
constexpr double kReaction_s = 5;

std::ofstream open_file(const std::string& path) {
  std::ofstream file(path);
  if (!file) throw Failure(path + ": cannot be written");
  return file;
}

}  // namespace

const char* to_string(Activity activity) { return name_of(kActivities, activity); }
const char* to_string(PlanningStep step) { return name_of(kSteps, step); }
const char* to_string(RequestVerb verb) { return name_of(kVerbs, verb); }

std::optional<RequestVerb> verb_from(const std::string& name) {
  const auto found = std::find(kVerbs.begin() + 1, kVerbs.end(), name);
  if (found == kVerbs.end()) return std::nullopt;
  return static_cast<RequestVerb>(found - kVerbs.begin());
}

Flight::Flight(const mission::Mission& mission, World& world, const FlightConfig& config)
    : mission_(mission), world_(world), config_(config) {
  if (config_.out.empty()) return;
  tracks_ = open_file(config_.out + "/tracks.csv");
  tracks_ << kTrackColumns << ",activity\n";
  events_ = open_file(config_.out + "/events.jsonl");
  if (!config_.trace) return;
  trace_file_ = open_file(config_.out + "/trace.csv");
  trace_file_ << "t_s,part,robot,trace\n";
}

void Flight::tick_begins(std::uint64_t k, const mission::Truth& truth) {
  now_ = time_of_tick(k);
  trace_.add(k);
  fold("world", kWorldId.value, world_.trace());
  for (const mission::TrueState& robot : truth.robots) state_[robot.robot] = robot.state;
  for (const mission::ScriptedEvent& scripted : mission_.script) {
    const auto verb = verb_from(scripted.verb);
    if (scripted.due_at(k) && verb && *verb >= RequestVerb::kReturn && scripted.robot == kNoRobot)
      called_home_ = now_;
  }
  note_faults(k);
  if (k % kTrackEvery == 0) write_tracks(truth);
}

/// Beginnings of what lasts a while; kills and requests have events of their own.
void Flight::note_faults(std::uint64_t k) {
  for (const mission::ScriptedEvent& e : mission_.script) {
    if (!e.due_at(k) || (e.lasts.us == 0 && e.verb != "drain")) continue;
    nlohmann::json line = {{"t_s", now_.s()}, {"event", "fault"}, {"verb", e.verb}};
    if (e.robot != kNoRobot) line["robot"] = e.robot.value;
    if (e.other != kNoRobot) line["other"] = e.other.value;
    if (e.lasts.us > 0) line["for_s"] = e.lasts.s();
    event(line);
  }
}

void Flight::station_heard(const std::vector<mission::Message>& messages) {
  for (const mission::Message& message : messages) {
    if (mission::is_record(message.cls)) world_.station_received(dds::unwrap(message), message.cls);
  }
}

void Flight::robot_done(const RobotReport& report) {
  fold("robot", report.robot.value, report.trace);
  activity_[report.robot] = report.activity;
  for (const mission::PlanningTime& time : report.planning)
    planning_[time.step].push_back(time.wall_ms);
  if (report.declares_complete && !declared_) {
    declared_ = now_;
    world_.station_declares_complete();
  }
}

void Flight::radio_done(std::uint64_t trace) { fold("radio", kRadioId.value, trace); }

void Flight::fold(const char* part, std::uint32_t id, std::uint64_t trace) {
  trace_.add(trace);
  if (!trace_file_.is_open()) return;
  trace_file_ << fmt::format("{:.1f},{},{},{:016x}\n", now_.s(), part, id, trace);
}

std::optional<std::string> Flight::end_reason(std::uint64_t k, std::size_t alive) {
  ++ticks_;
  write_events();
  const SimTime next = time_of_tick(k + 1);
  const auto waited = [&](SimTime since, double limit_s) {
    return next - since >= Duration::from_s(limit_s);
  };
  if (declared_ && (world_.progress().all_landed || waited(*declared_, kHomecoming_s)))
    return "declared complete";
  if (called_home_ && waited(*called_home_, kReaction_s) && world_.progress().all_landed)
    return "called home, all have landed";
  if (station_lost_ && next.s() > kReaction_s && world_.progress().all_landed)
    return "the station is lost, all have landed";
  if (alive == 0) return "no robot is left";
  if (next.s() >= mission_.time_limit_s) return "time limit";
  if (config_.duration_s > 0 && next.s() >= config_.duration_s - 1e-9) return "duration reached";
  return std::nullopt;
}

void Flight::robot_lost(RobotId robot, const std::string& how) {
  if (!gone_.insert(robot).second) return;
  lost_.push_back({{"robot", robot.value},
                   {"t_s", now_.decimal_s()},
                   {"how", how},
                   {"revived_s", nullptr},
                   {"journal_lost", false}});
  activity_.erase(robot);
  if (robot == mission_.station()) station_lost_ = true;
  event({{"t_s", now_.s()}, {"event", "robot_lost"}, {"robot", robot.value}, {"how", how}});
}

void Flight::robot_back(RobotId robot) {
  gone_.erase(robot);
  for (nlohmann::json& lost : lost_) {
    if (lost["robot"] != robot.value || !lost["revived_s"].is_null()) continue;
    const SimTime died = SimTime::from_s(lost["t_s"].get<double>());
    lost["revived_s"] = now_.decimal_s();
    lost["journal_lost"] = mission::lost_journal(mission_.script, robot, died, now_ + kTick);
  }
  if (robot == mission_.station()) station_lost_ = false;
  event({{"t_s", now_.s()}, {"event", "robot_back"}, {"robot", robot.value}});
}

void Flight::request(RequestVerb verb, RobotId robot) {
  world_.operator_request(verb, robot);
  if (verb >= RequestVerb::kReturn && robot == kNoRobot) called_home_ = now_;
  if (verb == RequestVerb::kResume) called_home_.reset();
  nlohmann::json line = {{"t_s", now_.s()}, {"event", "request"}, {"verb", to_string(verb)}};
  if (robot != kNoRobot) line["robot"] = robot.value;
  event(line);
}

void Flight::event(const nlohmann::json& event) {
  if (events_.is_open()) events_ << event.dump() << '\n';
}

void Flight::write_events() {
  for (const nlohmann::json& line : world_.take_events()) event(line);
}

void Flight::write_tracks(const mission::Truth& truth) {
  if (!tracks_.is_open()) return;
  for (const mission::TrueState& robot : truth.robots) {
    const auto activity = activity_.find(robot.robot);
    const char* doing = robot.state == mission::VehicleState::kDead ? "lost"
                        : activity == activity_.end()               ? "idle"
                                                                    : to_string(activity->second);
    tracks_ << track_row(now_, robot) << ',' << doing << '\n';
  }
}

nlohmann::json Flight::progress() const {
  const World::Progress p = world_.progress();
  nlohmann::json robots = nlohmann::json::object();
  for (const mission::RobotConfig& robot : mission_.fleet) {
    const auto activity = activity_.find(robot.id);
    robots[std::to_string(robot.id.value)] = gone_.contains(robot.id) ? "lost"
                                             : activity == activity_.end()
                                                 ? "idle"
                                                 : to_string(activity->second);
  }
  return {{"t_s", now_.s()},
          {"map_coverage", p.map_coverage},
          {"features_total", p.features_total},
          {"features_found", p.features_found},
          {"features_inspected", p.features_inspected},
          {"features_delivered", p.features_delivered},
          {"collisions", p.collisions},
          {"declared", p.declared},
          {"robots", std::move(robots)}};
}

nlohmann::json Flight::planning_summary() const {
  nlohmann::json all = nlohmann::json::object();
  for (auto [step, times] : planning_) {
    std::sort(times.begin(), times.end());
    const auto p95 =
        static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(times.size()))) - 1;
    all[to_string(step)] = {{"count", times.size()},
                            {"mean", std::accumulate(times.begin(), times.end(), 0.0) /
                                         static_cast<double>(times.size())},
                            {"p95", times[p95]},
                            {"max", times.back()}};
  }
  return all;
}

nlohmann::json Flight::finish(const std::string& reason) {
  write_events();
  event({{"t_s", now_.s()}, {"event", "end"}, {"reason", reason}});
  if (!config_.out.empty()) open_file(config_.out + "/features.csv") << world_.features_csv();
  tracks_.flush();
  trace_file_.flush();
  events_.flush();

  const World::Progress p = world_.progress();
  nlohmann::json summary = world_.summary();
  summary["mission"] = mission_.name;
  summary["strategy"] = mission_.strategy;
  summary["seed"] = mission_.seed;
  summary["ended"] = reason;
  summary["simulated_s"] = static_cast<double>(ticks_) * kTick.s();
  summary["declared"] = p.declared;
  summary["complete"] = p.declared && p.features_delivered == p.features_total;
  summary["trace_hash"] = fmt::format("{:016x}", trace_.value());
  summary["robots_lost"] = lost_;
  summary["fleet"] = nlohmann::json::array();
  for (const mission::RobotConfig& robot : mission_.fleet) {
    summary["fleet"].push_back({{"id", robot.id.value}, {"role", mission::role_name(robot.role)}});
  }
  summary["planning_ms"] = planning_summary();
  return summary;
}

}  // namespace muster::world
