#pragma once

#include <CLI/CLI.hpp>

namespace muster::command {

/// `muster scene info|convert|render`: what a scene or a mission's site holds, in numbers and in
/// pictures.
void add_scene_command(CLI::App& app);

}  // namespace muster::command
