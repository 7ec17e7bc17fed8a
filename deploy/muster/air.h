#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deploy/muster/report_data.h"

namespace muster::command {

/// What a run's air.csv says (commsim/air_log.h has its columns), pair by pair.
struct AirData {
  struct Moment {
    double t_s = 0;
    std::uint64_t bytes = 0;  ///< heard
    std::uint64_t lost = 0;   ///< messages that distance and walls do not explain
  };
  /// What one robot said, as another heard it.
  struct Way {
    std::uint64_t messages = 0, bytes = 0, dropped_bytes = 0;
    std::map<std::string, std::uint64_t> dropped;  ///< by reason
    std::vector<Moment> moments;                   ///< in order of time
  };
  struct Pair {
    std::uint32_t a = 0, b = 0;  ///< a < b
    Way from_a, from_b;
    std::vector<std::pair<double, double>> contacts;  ///< [from, until] in s, ascending
    double together_s = 0, longest_apart_s = 0;
    bool ever() const { return from_a.messages + from_b.messages > 0; }
  };

  /// What meetings were for. Heard bytes count once per pair that heard them.
  struct Meetings {
    std::uint64_t count = 0;  ///< after more than 30 s apart; other contacts only go on
    std::uint64_t bytes = 0, map_bytes = 0;  ///< heard
    double together_s = 0, data_s = 0;       ///< pairs' contact, and that with more than beacons
    std::uint64_t map_bytes_sent = 0;        ///< on air, whoever heard it
    /// Had both sent, at each meeting, all that they knew of the place (mission::WholeMapBytes);
    /// --transport memory only.
    std::optional<std::uint64_t> whole_map_bytes, whole_octree_bytes;
  };

  RunData run;
  Meetings meetings;
  std::vector<Pair> pairs;  ///< every pair that said something, ascending
  std::map<std::string, std::uint64_t> dropped() const;
  double step_s = 2;  ///< between moments
};

/// Throws BadInput when `dir` holds no run, or one without a record of its air.
AirData read_air(const std::string& dir);

std::string air_table(const AirData& air);    ///< for a terminal
nlohmann::json air_json(const AirData& air);  ///< for machines
std::string air_page(const AirData& air);     ///< one self-contained page

/// `muster air DIR`.
void add_air_command(CLI::App& app);

}  // namespace muster::command
