#include "deploy/muster/pose_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>

#include "common/core/error.h"
#include "deploy/muster/csv.h"

namespace muster::command {
namespace {

/// Reads a file of commas line by line, and complains with its line.
class Table {
 public:
  explicit Table(const std::string& file) : file_(file), in_(file) {
    if (!in_) throw BadInput(file + ": there is no such file");
    if (!next()) fail("is empty; its first line names the columns: t_s,robot,x,y,z,yaw_rad");
    names_ = cells_;
  }

  bool next() {
    std::string text;
    do {
      ++line_;
      if (!std::getline(in_, text)) return false;
      if (text.ends_with('\r')) text.pop_back();
    } while (text.empty());
    const auto cells = cells_of(text);
    cells_.assign(cells.begin(), cells.end());
    if (!names_.empty() && cells_.size() != names_.size())
      fail(fmt::format("has {} cells, and the first line names {} columns", cells_.size(),
                       names_.size()));
    return true;
  }

  std::optional<std::size_t> find(std::string_view name) const {
    const auto at = std::ranges::find(names_, name);
    if (at == names_.end()) return std::nullopt;
    return static_cast<std::size_t>(at - names_.begin());
  }
  std::size_t column(std::string_view name) const {
    const auto at = find(name);
    if (!at) fail(fmt::format("the column {} is missing", name));
    return *at;
  }

  double number(std::size_t column) const {
    const std::string& cell = cells_[column];
    const auto value = number_in<double>(cell);
    if (!value || !std::isfinite(*value))
      fail(fmt::format("{}: '{}' is not a number", names_[column], cell));
    return *value;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw BadInput(fmt::format("{}:{}: {}", file_, line_, what));
  }

 private:
  std::string file_;
  std::ifstream in_;
  int line_ = 0;
  std::vector<std::string> names_, cells_;
};

RobotId read_robot(const Table& table, std::size_t column, const mission::Mission& mission) {
  const double number = table.number(column);
  for (const mission::RobotConfig& robot : mission.fleet) {
    if (number == robot.id.value) return robot.id;
  }
  table.fail(fmt::format("robot: the mission has no robot {}", number));
}

/// The short way round.
double turn(double from_rad, double to_rad, double share) {
  return wrap_angle(from_rad + share * wrap_angle(to_rad - from_rad));
}

}  // namespace

PoseLog PoseLog::load(const std::string& file, const mission::Mission& mission) {
  Table table(file);
  const std::size_t t = table.column("t_s"), robot = table.column("robot"), x = table.column("x"),
                    y = table.column("y"), z = table.column("z");
  const auto yaw = table.find("yaw_rad");
  PoseLog log;
  while (table.next()) {
    std::vector<Row>& track = log.tracks_[read_robot(table, robot, mission)];
    const Row row{
        table.number(t),
        {Vec3(table.number(x), table.number(y), table.number(z)), yaw ? table.number(*yaw) : 0}};
    if (!track.empty() && row.t_s <= track.back().t_s)
      table.fail(fmt::format("t_s: {} is not after {}, the row before of the same robot", row.t_s,
                             track.back().t_s));
    track.push_back(row);
  }
  if (log.tracks_.empty()) table.fail("there are no poses");
  log.begin_s_ = log.tracks_.begin()->second.front().t_s;
  log.end_s_ = log.begin_s_;
  for (const auto& [id, track] : log.tracks_) {
    log.begin_s_ = std::min(log.begin_s_, track.front().t_s);
    log.end_s_ = std::max(log.end_s_, track.back().t_s);
  }
  return log;
}

std::set<RobotId> PoseLog::robots() const {
  std::set<RobotId> all;
  for (const auto& [id, track] : tracks_) all.insert(id);
  return all;
}

std::vector<mission::TrueState> PoseLog::at(double t_s) const {
  std::vector<mission::TrueState> known;
  for (const auto& [id, track] : tracks_) {
    const auto after = std::ranges::lower_bound(track, t_s, {}, &Row::t_s);
    if (after == track.end()) continue;
    Pose pose = after->pose;
    if (after->t_s > t_s) {
      if (after == track.begin() || after->t_s - (after - 1)->t_s > kGap_s) continue;
      const Row& before = *(after - 1);
      const double share = (t_s - before.t_s) / (after->t_s - before.t_s);
      pose.p = before.pose.p + share * (after->pose.p - before.pose.p);
      pose.yaw_rad = turn(before.pose.yaw_rad, after->pose.yaw_rad, share);
    }
    known.push_back({id, mission::VehicleState::kMoving, pose, Vec3::Zero()});
  }
  return known;
}

}  // namespace muster::command
