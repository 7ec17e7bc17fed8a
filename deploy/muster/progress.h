#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

namespace muster::command {

/// Tells how a run is going on stdout: one line that is rewritten on a terminal, a line every 10
/// simulated seconds when piped, one JSON object per simulated second with `--json`.
class Progress {
 public:
  enum class Form { kTerminal, kPlain, kJson };
  static Form form_for(bool json);  ///< looks at whether stdout is a terminal

  explicit Progress(Form form);
  /// What `Flight::progress` says, once per simulated second.
  void show(nlohmann::json state);
  /// The mission starts now: the real-time factor counts from here.
  void restart_clock();
  /// A line of its own ("robot 3 was lost").
  void note(const std::string& line);
  /// The end: the table, or the summary as one JSON object.
  void result(const nlohmann::json& summary, const std::string& dir);

 private:
  void clear_line();

  Form form_;
  bool line_open_ = false;
  double next_plain_s_ = 0;
  std::chrono::steady_clock::time_point start_, last_shown_;
};

/// "explorer 2 exploring 4 inspecting …": how many robots do what, as "2 exploring, 1 waiting".
std::string count_activities(const nlohmann::json& robots);

}  // namespace muster::command
