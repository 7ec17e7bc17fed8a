#include "deploy/muster/run_options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "common/core/error.h"

namespace muster::command {

namespace {

/// What a script asks for and nobody could do would seem to have been survived.
void check_script(const std::vector<mission::ScriptedEvent>& script, const RunOptions& options) {
  static constexpr std::array<std::string_view, 7> kWithoutRadio{
      "hold", "resume", "return", "land", "abort", "drain", "blind"};
  for (const mission::ScriptedEvent& e : script) {
    const bool starts = e.verb == "kill" || e.verb == "revive";
    if (starts && std::ranges::count(options.external, e.robot.value) > 0) {
      throw BadInput(fmt::format(
          "--external {0}: the script has a {1} of robot {0} at {2} s, but its process is yours to "
          "start and to kill",
          e.robot.value, e.verb, e.at.decimal_s()));
    }
    if (options.link == "direct" && std::ranges::find(kWithoutRadio, e.verb) == kWithoutRadio.end())
      throw BadInput(fmt::format(
          "--link direct: the mission's script has a {} at {} s, which needs --link radio", e.verb,
          e.at.decimal_s()));
  }
}

}  // namespace

std::vector<std::string> RunOptions::overrides() const {
  std::vector<std::string> all = set;
  if (strategy) all.push_back("strategy=" + *strategy);
  if (seed) all.push_back("seed=" + std::to_string(*seed));
  return all;
}

double RunOptions::speed_factor() const {
  if (speed == "max") return 0;
  char* end = nullptr;
  const double factor = std::strtod(speed.c_str(), &end);
  if (end == speed.c_str() || *end != '\0' || !std::isfinite(factor) || factor <= 0) {
    throw BadInput("--speed: '" + speed + "' is neither max nor a number above 0");
  }
  return factor;
}

void RunOptions::validate(const mission::Mission& mission) const {
  if (!std::isfinite(duration_s) || duration_s < 0)
    throw BadInput("--duration: must be a number of seconds, 0 or more");
  if (!std::isfinite(restart_s) || restart_s < 0)
    throw BadInput("--restart: must be a number of seconds, 0 or more");
  if (restart_s > 0 && (transport == "memory" || link == "direct"))
    throw BadInput("--restart: needs --transport dds and --link radio");
  if (link == "direct" && transport == "memory") {
    throw BadInput("--link direct: needs processes of their own, so --transport dds");
  }
  if (link == "direct" && speed == "max") {
    throw BadInput("--link direct: everyone flies on their own clock; say how fast with --speed 1");
  }
  if (link == "direct" && !faults.empty())
    throw BadInput("--faults: needs the simulated radio, so --link radio");
  if (transport == "memory" && !external.empty())
    throw BadInput("--external: needs --transport dds");
  if (transport == "memory" && capture)
    throw BadInput("--capture: with --transport memory nothing goes over the network");
  for (std::uint32_t id : external) {
    if (!mission.has(RobotId{id})) {
      throw BadInput("--external: the mission has no robot " + std::to_string(id));
    }
  }
  check_script(mission.script, *this);
  speed_factor();
}

bool prepare_output(const std::string& dir) {
  std::error_code error;
  const bool is_new = !std::filesystem::exists(dir, error);
  std::filesystem::create_directories(dir + "/logs", error);
  if (error) throw Failure("--out: " + dir + ": cannot be made: " + error.message());
  for (const std::string& place : {dir, dir + "/logs"}) {
    if (access(place.c_str(), W_OK | X_OK) != 0)
      throw Failure("--out: " + place + ": cannot be written to");
  }
  // What robots kept of an earlier run is not theirs to go on with.
  std::filesystem::remove_all(dir + "/state", error);
  return is_new;
}

void remove_results(const std::string& dir, bool keep_logs) {
  std::error_code error;
  std::vector<std::filesystem::path> results;
  for (const auto& entry : std::filesystem::directory_iterator(dir, error)) {
    if (!keep_logs || entry.path().filename() != "logs") results.push_back(entry.path());
  }
  for (const auto& path : results) std::filesystem::remove_all(path, error);
  std::filesystem::remove(dir, error);  // only if it is empty now
}

}  // namespace muster::command
