#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/mission/messages.h"

namespace muster::command {

/// What a run left in its directory, read for `muster report`. Whatever is missing or damaged is
/// left empty and named in `notes`: a run that was cut short is the one most in need of a report.
struct RunData {
  struct Sample {
    double t_s = 0, x = 0, y = 0, z = 0;
    std::string activity;
  };
  struct Robot {
    std::uint32_t id = 0;
    mission::Role role{};
    std::vector<Sample> track;  ///< in order of time, about one a second
    std::optional<double> lost_s;
  };
  struct Feature {
    std::uint32_t id = 0;
    double x = 0, y = 0, z = 0;
    std::optional<double> sighted_s, inspected_s, delivered_s;
  };
  struct Contact {
    std::uint32_t a = 0, b = 0;
    double from_s = 0, until_s = 0;
  };
  /// One line of events.jsonl.
  struct Event {
    double t_s = 0;
    std::string name;
    std::optional<std::uint32_t> robot;
    nlohmann::json all;
  };

  std::string dir;
  nlohmann::json summary = nlohmann::json::object();
  std::vector<Event> events;
  std::vector<Robot> robots;  ///< by id
  std::vector<Feature> features;
  std::vector<Contact> contacts;
  double end_s = 0;  ///< the last instant that anything is known of; > 0
  std::vector<std::string> notes;

  const Robot* robot(std::uint32_t id) const;
  bool complete() const;
};

/// Throws BadInput when `dir` is no directory, or holds nothing of a run.
RunData read_run(const std::string& dir);

/// "station 1", "explorer 2": what people call it.
std::string robot_name(const RunData::Robot& robot);

}  // namespace muster::command
