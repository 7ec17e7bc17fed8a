#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace muster::command {

/// What a run cost the machine it ran on. Measured, so never part of the trace.
struct Cost {
  double wall_s = 0;
  double cpu_s = 0;                    ///< all processes together
  std::optional<double> agent_rss_mb;  ///< the largest agent; none when all share one process
  std::optional<double> station_rss_mb;
};

/// Adds the cost to what the flight and the radio summed up (in place).
void add_cost(nlohmann::json& summary, const Cost& cost, std::size_t robots);
/// DIR/summary.json, whole or not at all. Throws Failure.
void write_summary(const std::string& dir, const nlohmann::json& summary);
/// A small aligned table for people.
std::string summary_table(const nlohmann::json& summary);
/// 0 complete, 3 incomplete or declared falsely, 1 when the run itself failed.
int exit_status(const nlohmann::json& summary);

}  // namespace muster::command
