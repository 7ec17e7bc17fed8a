#include "deploy/muster/summary.h"

#include <fmt/format.h>

#include "common/core/error.h"
#include "deploy/muster/write_file.h"

namespace muster::command {
namespace {

using nlohmann::json;

/// A number with `digits`, or "–" for null and absent ones.
std::string number(const json& summary, const char* key, int digits, const char* unit = "") {
  const auto found = summary.find(key);
  if (found == summary.end() || !found->is_number()) return "–";
  return fmt::format("{:.{}f}{}", found->get<double>(), digits, unit);
}

std::string text(const json& summary, const char* key) {
  const auto found = summary.find(key);
  if (found == summary.end() || found->is_null()) return "–";
  return found->is_string() ? found->get<std::string>() : found->dump();
}

std::string lost(const json& summary) {
  const auto found = summary.find("robots_lost");
  if (found == summary.end() || !found->is_array() || found->empty()) return "none";
  std::string all;
  for (const json& robot : *found) {
    all += fmt::format("{}{} at {:.1f} s ({})", all.empty() ? "" : ", ", robot.value("robot", 0u),
                       robot.value("t_s", 0.0), robot.value("how", ""));
  }
  return all;
}

/// Empty: nothing had to be.
std::string redone(const json& summary) {
  const auto found = summary.find("features_redone");
  if (found == summary.end() || !found->is_array() || found->empty()) return "";
  std::string all;
  std::size_t open = 0;
  for (const json& f : *found) {
    all += fmt::format("{}{}", all.empty() ? "" : ", ", f.value("feature", 0u));
    open += f.contains("again_s") && f["again_s"].is_null() ? 1 : 0;
  }
  return open == 0 ? all : fmt::format("{}; {} of them not yet", all, open);
}

/// Empty: no journal was there to be judged.
std::string forgotten(const json& summary) {
  const auto found = summary.find("records_lost");
  if (found == summary.end() || !found->is_object()) return "";
  const auto count = found->value("count", 0u), journals = found->value("journals", 0u);
  if (journals == 0) return "";
  return fmt::format("{} that a robot had said to hold   {} journals judged",
                     count == 0 ? "none" : std::to_string(count), journals);
}

}  // namespace

void add_cost(json& summary, const Cost& cost, std::size_t robots) {
  const double simulated_s = summary.value("simulated_s", 0.0);
  const auto optional = [](const std::optional<double>& v) { return v ? json(*v) : json(nullptr); };
  summary["wall_s"] = cost.wall_s;
  summary["real_time_factor"] = cost.wall_s > 0 ? json(simulated_s / cost.wall_s) : json(nullptr);
  summary["cpu_ms_per_robot_s"] =
      simulated_s > 0 ? json(1000 * cost.cpu_s / (static_cast<double>(robots) * simulated_s))
                      : json(nullptr);
  summary["agent_rss_mb"] = optional(cost.agent_rss_mb);
  summary["station_rss_mb"] = optional(cost.station_rss_mb);
}

void write_summary(const std::string& dir, const json& summary) {
  write_file(dir + "/summary.json", summary.dump(2) + "\n");
}

std::string summary_table(const json& s) {
  std::string table;
  const auto row = [&](const char* name, const std::string& value) {
    table += fmt::format("  {:<22}{}\n", name, value);
  };
  row("mission",
      fmt::format("{} · {} · seed {}", text(s, "mission"), text(s, "strategy"), text(s, "seed")));
  row("result", fmt::format("{} ({})", s.value("complete", false) ? "complete" : "not complete",
                            text(s, "ended")));
  row("simulated", number(s, "simulated_s", 1, " s"));
  row("T", fmt::format("{}   last feature {}   declared {}   home {}", number(s, "t_s", 1, " s"),
                       number(s, "delivered_time_s", 1, " s"), number(s, "finish_time_s", 1, " s"),
                       number(s, "home_time_s", 1, " s")));
  row("features delivered",
      fmt::format("{} of {}", number(s, "features_delivered", 0), number(s, "features_total", 0)));
  row("map coverage", number(s, "map_coverage", 3));
  row("collisions",
      fmt::format("{}   nearest robots {}   nearest surface {}", number(s, "collisions", 0),
                  number(s, "min_separation_m", 2, " m"), number(s, "min_clearance_m", 2, " m")));
  row("robots lost", lost(s));
  const std::string records = forgotten(s), features = redone(s);
  if (!records.empty()) row("records lost", records);
  if (!features.empty()) row("inspected again", features);
  row("speed",
      fmt::format("{}× real time, {} of CPU per robot and second, {} per agent",
                  number(s, "real_time_factor", 1), number(s, "cpu_ms_per_robot_s", 1, " ms"),
                  number(s, "agent_rss_mb", 0, " MB")));
  row("trace", text(s, "trace_hash"));
  return table;
}

int exit_status(const json& summary) {
  if (summary.value("failed", false)) return kExitFailure;
  return summary.value("complete", false) ? kExitComplete : kExitIncomplete;
}

}  // namespace muster::command
