#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/core/ids.h"
#include "common/core/line_channel.h"

namespace muster::command {

/// How a process is started: `program` lies beside this one.
struct ChildConfig {
  std::string name;     ///< "world", "agent-3": for people and for log files
  std::string program;  ///< "muster-agent"
  std::vector<std::string> arguments;
  std::string log_dir;  ///< gets NAME.err with what it says on stdout and stderr
  RobotId robot = kNoRobot;
  bool again = false;    ///< NAME.err is gone on with, not begun anew
  bool channel = false;  ///< with a control channel; `--control-fd N` is added to the arguments
};

/// A process that this one started. Killed and reaped with the object.
class Child {
 public:
  /// Throws Failure when it cannot be started.
  explicit Child(const ChildConfig& config);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  const std::string& name() const { return config_.name; }
  RobotId robot() const { return config_.robot; }
  LineChannel* channel() { return channel_.get(); }
  int pidfd() const { return pidfd_; }  ///< readable once it has ended
  pid_t pid() const { return pid_; }

  void signal(int number);
  /// After `pidfd` became readable.
  void reap();
  bool running() const { return pid_ > 0; }

  /// "killed by signal 9", "ended with status 1"; after `reap`.
  std::string how_ended() const;
  int exit_code() const;  ///< 1 when it was killed
  /// CPU time since it started; all of it once it has ended.
  double cpu_s() const;
  /// Largest resident memory so far.
  double peak_rss_mb() const { return peak_rss_mb_; }
  void measure_memory();
  /// The last line it said on stderr; empty when it said nothing.
  std::string last_words() const;

 private:
  std::string error_file() const { return config_.log_dir + "/" + config_.name + ".err"; }

  ChildConfig config_;
  pid_t pid_ = -1;
  int pidfd_ = -1;
  int status_ = 0;
  double cpu_s_ = 0, peak_rss_mb_ = 0;
  std::unique_ptr<LineChannel> channel_;
};

/// Where this program's own file lies: the other programs are beside it.
std::string program_directory();

}  // namespace muster::command
