#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/mission/mission.h"

namespace muster::command {

/// The options of `muster run` (DESIGN "The command").
struct RunOptions {
  std::string mission_file;
  std::optional<std::string> strategy;
  std::optional<std::uint64_t> seed;
  std::string dds = "cyclonedds";  ///< cyclonedds | fastdds | mixed
  std::string transport = "dds";   ///< dds | memory
  std::string link = "radio";      ///< radio | direct
  std::string speed = "max";       ///< max, or times real time
  std::vector<std::string> set;    ///< key=value
  std::string faults;              ///< a file with more of a script; empty: none
  std::vector<std::uint32_t> external;
  std::string out;                      ///< default: runs/<mission name>
  bool out_is_new = false;              ///< made for this run
  std::optional<std::uint32_t> domain;  ///< of the bus; over DDS, a free one once it is chosen
  double duration_s = 0;
  double restart_s = 0;  ///< who died by itself is started again after so long; 0: never
  bool print_config = false;
  bool trace = false;
  bool json = false;
  bool report = true;
  bool capture = false;

  /// `set` with --strategy and --seed folded in: what `Mission::load` and every child process are
  /// given.
  std::vector<std::string> overrides() const;
  /// 0: as fast as possible.
  double speed_factor() const;
  /// Throws BadInput for values that contradict each other or the mission.
  void validate(const mission::Mission& mission) const;
};

/// Makes DIR and DIR/logs; whether DIR was not there before. Throws Failure when nothing can be
/// written there.
bool prepare_output(const std::string& dir);
/// Of a run that never began: nothing half-written stays. `keep_logs`: where they may say why.
void remove_results(const std::string& dir, bool keep_logs);

}  // namespace muster::command
