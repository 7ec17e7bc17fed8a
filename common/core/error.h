#pragma once

#include <stdexcept>
#include <string>

namespace muster {

/// What the user gave us is wrong: a file, key, flag or message. `what()` is one line that names
/// the place and says what would be right. Programs print it and exit with status 2.
class BadInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The surroundings failed us: a port in use, a directory not writable. Programs print it and exit
/// with status 1.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

inline constexpr int kExitComplete = 0;
inline constexpr int kExitFailure = 1;
inline constexpr int kExitBadInput = 2;
inline constexpr int kExitIncomplete = 3;

/// Aborts with the invariant's name: a bug of ours, never bad input.
[[noreturn]] void broken_invariant(const char* what, const char* file, int line);

}  // namespace muster

#define MUSTER_CHECK(condition) \
  ((condition) ? void() : ::muster::broken_invariant(#condition, __FILE__, __LINE__))
