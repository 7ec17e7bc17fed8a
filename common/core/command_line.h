#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "common/core/error.h"

namespace muster {

/// Parses the command line of a program into what `app`'s options point to. False: --help or
/// --version was asked for and answered. Throws BadInput in one line. Header-only, so that only
/// programs need CLI11.
inline bool parse_command_line(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) throw BadInput(std::string(e.what()) + " (see --help)");
    app.exit(e);
    return false;
  }
  return true;
}

}  // namespace muster
