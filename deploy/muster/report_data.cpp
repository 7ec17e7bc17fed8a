#include "deploy/muster/report_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"
#include "deploy/muster/csv.h"

namespace muster::command {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::optional<double> time_of(const json& object) {
  for (const char* key : {"t_s", "t"}) {
    if (object.contains(key) && object[key].is_number()) return object[key].get<double>();
  }
  return std::nullopt;
}

/// A CSV file with a header, row by row; columns are asked for by name, so that new ones disturb
/// nobody.
class Csv {
 public:
  Csv(const std::string& path, std::vector<std::string>& notes) : file_(path) {
    std::string line;
    if (!std::getline(file_, line)) {
      notes.push_back(fs::path(path).filename().string() + " is missing");
      return;
    }
    if (line.empty()) return;
    const std::vector<std::string> names = split(line);
    for (std::size_t i = 0; i < names.size(); ++i) column_[names[i]] = i;
  }
  bool next() {
    std::string line;
    if (column_.empty() || !std::getline(file_, line)) return false;
    cells_ = split(line);
    return true;
  }
  std::string text(const std::string& name) const {
    const auto found = column_.find(name);
    return found == column_.end() || found->second >= cells_.size() ? "" : cells_[found->second];
  }
  std::optional<double> value(const std::string& name) const {
    const auto number = number_in<double>(text(name));
    return number && std::isfinite(*number) ? number : std::nullopt;
  }

 private:
  static std::vector<std::string> split(std::string_view line) {
    if (line.ends_with('\r')) line.remove_suffix(1);
    const auto cells = cells_of(line);
    return {cells.begin(), cells.end()};
  }
  std::ifstream file_;
  std::map<std::string, std::size_t> column_;
  std::vector<std::string> cells_;
};

void read_summary(RunData& run) {
  std::ifstream file(run.dir + "/summary.json");
  if (!file) {
    run.notes.push_back("summary.json is missing: the run did not end by itself");
    return;
  }
  json summary = json::parse(file, nullptr, false);
  if (summary.is_object()) {
    run.summary = std::move(summary);
  } else {
    run.notes.push_back("summary.json is damaged");
  }
}

void read_events(RunData& run) {
  std::ifstream file(run.dir + "/events.jsonl");
  if (!file) run.notes.push_back("events.jsonl is missing");
  std::size_t damaged = 0;
  for (std::string line; std::getline(file, line);) {
    json event = json::parse(line, nullptr, false);
    if (!event.is_object() || !time_of(event)) {
      ++damaged;
      continue;
    }
    RunData::Event e{*time_of(event), "", std::nullopt, std::move(event)};
    if (e.all.contains("event") && e.all["event"].is_string())
      e.name = e.all["event"].get<std::string>();
    if (e.all.contains("robot") && e.all["robot"].is_number_unsigned())
      e.robot = e.all["robot"].get<std::uint32_t>();
    run.events.push_back(std::move(e));
  }
  if (damaged > 0)
    run.notes.push_back(std::to_string(damaged) + " lines of events.jsonl are damaged");
}

void read_tracks(RunData& run) {
  std::map<std::uint32_t, RunData::Robot> robots;
  for (Csv csv(run.dir + "/tracks.csv", run.notes); csv.next();) {
    const auto t = csv.value("t_s") ? csv.value("t_s") : csv.value("t");
    const auto id = csv.value("robot"), x = csv.value("x"), y = csv.value("y"), z = csv.value("z");
    if (!t || !id || !x || !y || !z || *id < 0) continue;
    RunData::Robot& robot = robots[static_cast<std::uint32_t>(*id)];
    robot.track.push_back({*t, *x, *y, *z, csv.text("activity")});
  }
  for (auto& [id, robot] : robots) {
    robot.id = id;
    run.robots.push_back(std::move(robot));
  }
}

void read_features(RunData& run) {
  for (Csv csv(run.dir + "/features.csv", run.notes); csv.next();) {
    const auto id = csv.value("id"), x = csv.value("x"), y = csv.value("y"), z = csv.value("z");
    if (!id || !x || !y || !z) continue;
    run.features.push_back({static_cast<std::uint32_t>(*id), *x, *y, *z, csv.value("sighted_s"),
                            csv.value("inspected_s"), csv.value("delivered_s")});
  }
}

std::optional<mission::Role> role_from(const std::string& name) {
  if (name == "station" || name == "gcs") return mission::Role::kStation;
  if (name == "explorer") return mission::Role::kExplorer;
  if (name == "inspector") return mission::Role::kInspector;
  return std::nullopt;
}

/// By what the summary says of the fleet; else by what each was seen doing, which tells the roles
/// apart by definition.
void assign_roles(RunData& run) {
  std::map<std::uint32_t, mission::Role> known;
  if (run.summary.contains("fleet") && run.summary["fleet"].is_array()) {
    for (const json& r : run.summary["fleet"]) {
      if (!r.is_object() || !r.contains("id") || !r["id"].is_number_unsigned()) continue;
      if (!r.contains("role") || !r["role"].is_string()) continue;
      if (const auto role = role_from(r["role"].get<std::string>()))
        known[r["id"].get<std::uint32_t>()] = *role;
    }
  }
  for (RunData::Robot& robot : run.robots) {
    const auto does = [&](const char* what) {
      return std::any_of(robot.track.begin(), robot.track.end(),
                         [&](const auto& s) { return s.activity == what; });
    };
    if (known.count(robot.id)) {
      robot.role = known[robot.id];
    } else {
      robot.role = does("exploring")    ? mission::Role::kExplorer
                   : does("inspecting") ? mission::Role::kInspector
                                        : mission::Role::kStation;
    }
  }
}

void mark_lost(RunData& run) {
  for (const RunData::Event& event : run.events) {
    if (!event.robot) continue;
    for (RunData::Robot& robot : run.robots) {
      if (robot.id != *event.robot) continue;
      if (event.name == "robot_lost") robot.lost_s = event.t_s;
      if (event.name == "robot_back") robot.lost_s.reset();
    }
  }
}

/// The radio's contacts: `contacts: [{"robots": [1, 2], "intervals": [[3.0, 9.5], …]}, …]`.
void read_contacts(RunData& run) {
  const json list = run.summary.contains("contacts") ? run.summary["contacts"] : json::array();
  try {
    for (const json& pair : list) {
      const auto robots = pair.at("robots").get<std::array<std::uint32_t, 2>>();
      for (const auto& [from_s, until_s] :
           pair.at("intervals").get<std::vector<std::array<double, 2>>>()) {
        run.contacts.push_back({robots[0], robots[1], from_s, until_s});
      }
    }
  } catch (const json::exception&) {
    run.notes.push_back("contacts in summary.json are damaged");
  }
}

double end_of(const RunData& run) {
  double end = 0;
  for (const auto& robot : run.robots) {
    if (!robot.track.empty()) end = std::max(end, robot.track.back().t_s);
  }
  for (const auto& event : run.events) end = std::max(end, event.t_s);
  if (run.summary.contains("simulated_s") && run.summary["simulated_s"].is_number()) {
    end = std::max(end, run.summary["simulated_s"].get<double>());
  }
  return end > 0 ? end : 1;
}

}  // namespace

bool RunData::complete() const {
  return summary.contains("complete") && summary["complete"].is_boolean() &&
         summary["complete"].get<bool>();
}

const RunData::Robot* RunData::robot(std::uint32_t id) const {
  const auto found =
      std::find_if(robots.begin(), robots.end(), [&](const Robot& r) { return r.id == id; });
  return found == robots.end() ? nullptr : &*found;
}

RunData read_run(const std::string& dir) {
  if (!fs::is_directory(dir)) throw BadInput(dir + ": no such directory; give the --out of a run");
  RunData run;
  run.dir = dir;
  constexpr std::array kFiles = {"summary.json", "events.jsonl", "tracks.csv", "features.csv",
                                 "map.bt"};
  const auto here = [&](const char* name) { return fs::exists(fs::path(dir) / name); };
  if (std::none_of(kFiles.begin(), kFiles.end(), here))
    throw BadInput(dir + ": nothing of a run in here; give the --out of a run");
  read_summary(run);
  read_events(run);
  read_tracks(run);
  read_features(run);
  assign_roles(run);
  mark_lost(run);
  read_contacts(run);
  run.end_s = end_of(run);
  return run;
}

std::string robot_name(const RunData::Robot& robot) {
  return std::string(mission::role_name(robot.role)) + " " + std::to_string(robot.id);
}

}  // namespace muster::command
