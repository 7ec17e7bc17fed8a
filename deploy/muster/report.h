#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "deploy/muster/report_data.h"

namespace muster::command {

/// `muster report DIR`.
void add_report_command(CLI::App& app);

/// Writes `<dir>/report.html`: one self-contained page. Throws BadInput when `dir` holds no run,
/// Failure when it is not writable.
void write_report(const std::string& dir);

/// The page of a run. `run.notes` grows by what could not be drawn.
std::string report_page(RunData run);

/// The page's style sheet and script; no other file and no network is used.
extern const char* const kReportStyle;
extern const char* const kReportScript;

}  // namespace muster::command
