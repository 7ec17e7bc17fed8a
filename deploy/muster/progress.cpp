#include "deploy/muster/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <map>

#include "deploy/muster/summary.h"

namespace muster::command {
namespace {

using Clock = std::chrono::steady_clock;

/// A terminal line is redrawn at most this often.
constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr double kPlainEvery_s = 10;

double seconds(Clock::duration d) { return std::chrono::duration<double>(d).count(); }

std::string line_of(const nlohmann::json& s) {
  return fmt::format(
      "{:7.1f} s  map {:5.1f} %  found {}/{}  inspected {}  delivered {}  {:.1f}×  {}",
      s.value("t_s", 0.0), 100 * s.value("map_coverage", 0.0), s.value("features_found", 0),
      s.value("features_total", 0), s.value("features_inspected", 0),
      s.value("features_delivered", 0), s.value("real_time_factor", 0.0),
      count_activities(s.at("robots")));
}

}  // namespace

std::string count_activities(const nlohmann::json& robots) {
  std::map<std::string, int> counts;
  for (const auto& activity : robots) ++counts[activity.get<std::string>()];
  std::string all;
  for (const auto& [activity, count] : counts)
    all += fmt::format("{}{} {}", all.empty() ? "" : ", ", count, activity);
  return all;
}

Progress::Form Progress::form_for(bool json) {
  if (json) return Form::kJson;
  return isatty(STDOUT_FILENO) ? Form::kTerminal : Form::kPlain;
}

Progress::Progress(Form form) : form_(form), start_(Clock::now()) {}

void Progress::show(nlohmann::json state) {
  const auto now = Clock::now();
  const double t_s = state.value("t_s", 0.0);
  state["real_time_factor"] = t_s / std::max(1e-3, seconds(now - start_));
  switch (form_) {
    case Form::kJson:
      fmt::print("{}\n", state.dump());
      break;
    case Form::kPlain:
      if (t_s < next_plain_s_) return;
      next_plain_s_ = t_s + kPlainEvery_s;
      fmt::print("{}\n", line_of(state));
      break;
    case Form::kTerminal:
      if (now - last_shown_ < kRedraw) return;
      last_shown_ = now;
      fmt::print("\r\x1b[2K{}", line_of(state));
      line_open_ = true;
      break;
  }
  std::fflush(stdout);
}

void Progress::restart_clock() { start_ = Clock::now(); }

void Progress::note(const std::string& line) {
  clear_line();
  if (form_ == Form::kJson) {
    fmt::print("{}\n", nlohmann::json{{"note", line}}.dump());
  } else {
    fmt::print("{}\n", line);
  }
  std::fflush(stdout);
}

void Progress::result(const nlohmann::json& summary, const std::string& dir) {
  clear_line();
  if (form_ == Form::kJson) {
    fmt::print("{}\n", nlohmann::json{{"summary", summary}}.dump());
  } else {
    fmt::print("\n{}  {:<22}{}\n", summary_table(summary), "files", dir);
  }
  std::fflush(stdout);
}

void Progress::clear_line() {
  if (line_open_) fmt::print("\n");
  line_open_ = false;
}

}  // namespace muster::command
