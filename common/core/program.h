#pragma once

#include <functional>

namespace muster {

/// Runs the body of a `main` and turns what it throws into one line on stderr and the exit status
/// of DESIGN "The command": BadInput 2, anything else 1.
int run_program(const char* name, const std::function<int()>& body);

/// Name of the environment variable in which `muster run` tells its children who it is (a process
/// id).
inline constexpr const char* kLauncherVariable = "MUSTER_LAUNCHER";

/// A child of `muster run` dies with it, and leaves Ctrl-C to it (the launcher asks everyone to end
/// and still writes the summary). Does nothing when the process was started by hand.
void end_with_launcher();

}  // namespace muster
