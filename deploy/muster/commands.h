#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace muster::command {

/// What the chosen subcommand does; returns the exit status.
using Action = std::function<int()>;

/// Each adds its subcommand to `app` and, when that is chosen, stores what to do in `action`.
void add_run_command(CLI::App& app, Action& action);
void add_ctl_command(CLI::App& app, Action& action);
void add_lab_command(CLI::App& app, Action& action);

}  // namespace muster::command
