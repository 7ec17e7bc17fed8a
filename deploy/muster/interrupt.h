#pragma once

namespace muster::command {

/// Turns Ctrl-C, SIGTERM and SIGHUP into a wish to end in order; a second one ends at once.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool wished() const;
  int fd() const;  ///< readable once wished, for `poll`
};

}  // namespace muster::command
