#pragma once

#include <nlohmann/json.hpp>

#include "deploy/muster/run_options.h"

namespace muster::command {

/// What every run leaves in its directory, however it was flown: summary.json and, unless
/// --no-report, report.html.
void finish_results(const RunOptions& options, const nlohmann::json& summary);

}  // namespace muster::command
