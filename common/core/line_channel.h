#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace muster {

/// Lines of text over a file descriptor: how `muster run` talks with the world and the radio that
/// it started (one JSON object a line), and `muster ctl` with `muster run`.
class LineChannel {
 public:
  /// Takes the descriptor and closes it.
  explicit LineChannel(int fd) : fd_(fd) {}
  ~LineChannel();
  LineChannel(const LineChannel&) = delete;
  LineChannel& operator=(const LineChannel&) = delete;

  /// The next line, without its end; waits for it. nullopt: the other side is gone.
  std::optional<std::string> read_line();
  /// The lines that are here already, after `poll` said that there is something to read; `closed`
  /// becomes true at the end.
  std::vector<std::string> read_available(bool& closed);
  /// False when the other side is gone. Thread-safe.
  bool write_line(std::string_view line);
  /// Wakes up whoever waits in `read_line` and ends the conversation.
  void shut_down();
  /// The other side's `read_line` comes to an end; ours goes on.
  void end_writing();
  int fd() const { return fd_; }

 private:
  bool take_line(std::string& line);
  bool fill();  // false: the other side is gone

  int fd_;
  std::string buffer_;
  std::mutex write_mutex_;
};

}  // namespace muster
