#pragma once

#include <spdlog/spdlog.h>

#include <string>

#include "common/core/ids.h"
#include "common/core/time.h"

namespace muster::log {

/// What is in the file before: another run's words, or those of a process whose successor this is.
enum class Before { kForget, kKeep };
/// Opens `<dir>/<name>.log` as the one sink of this process; every line is stamped with mission
/// time and `name`. Without it warnings go to stderr. Logs never feed a decision or the trace.
void open(const std::string& dir, const std::string& name, Before before = Before::kForget);

/// The mission time that the next lines are stamped with.
void set_time(SimTime now);
/// As `set_time`, and who speaks, where several robots share a process; `kNoRobot`: the process
/// itself.
void set_speaker(SimTime now, RobotId robot);

using spdlog::debug;
using spdlog::error;
using spdlog::info;
using spdlog::warn;

}  // namespace muster::log
