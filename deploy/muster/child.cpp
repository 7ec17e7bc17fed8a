#include "deploy/muster/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "common/core/error.h"

extern char** environ;

namespace muster::command {
namespace {

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  all.reserve(texts.size() + 1);
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

}  // namespace

std::string program_directory() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path().string();
}

Child::Child(const ChildConfig& config) : config_(config) {
  std::vector<std::string> arguments = {program_directory() + "/" + config.program};
  arguments.insert(arguments.end(), config.arguments.begin(), config.arguments.end());
  int ends[2] = {-1, -1};
  if (config.channel) {
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      throw Failure("cannot make a socket pair");
    channel_ = std::make_unique<LineChannel>(ends[0]);
    arguments.insert(arguments.end(), {"--control-fd", "3"});
  }

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  const int before = config.again ? O_APPEND : O_APPEND | O_TRUNC;
  posix_spawn_file_actions_addopen(&files, 1, error_file().c_str(), O_WRONLY | O_CREAT | before,
                                   0644);
  posix_spawn_file_actions_adddup2(&files, 1, 2);
  // dup2 onto itself would keep close-on-exec in place, so the number 3 must be free on our side:
  // it is whenever ends[1] is not 3.
  int theirs = ends[1];
  if (theirs == 3) theirs = fcntl(ends[1], F_DUPFD_CLOEXEC, 10);
  if (config.channel) posix_spawn_file_actions_adddup2(&files, theirs, 3);

  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  // A group of its own: Ctrl-C at the terminal reaches the launcher alone, which ends everybody in
  // order.
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  posix_spawnattr_setpgroup(&attributes, 0);
  sigset_t defaults;
  sigemptyset(&defaults);
  for (int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&defaults, number);
  posix_spawnattr_setsigdefault(&attributes, &defaults);

  const auto argv = pointers(arguments);
  const int error =
      posix_spawn(&pid_, arguments[0].c_str(), &files, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (theirs != ends[1]) ::close(theirs);
  if (ends[1] >= 0) ::close(ends[1]);
  if (error != 0) {
    pid_ = -1;
    throw Failure(fmt::format("{}: cannot be started: {}", arguments[0], std::strerror(error)));
  }
  pidfd_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  if (pidfd_ < 0) throw Failure("this kernel has no pidfd_open (Linux 5.3 or newer is needed)");
}

Child::~Child() {
  if (running()) {
    signal(SIGKILL);
    reap();
  }
  if (pidfd_ >= 0) ::close(pidfd_);
  std::error_code error;
  if (std::filesystem::file_size(error_file(), error) == 0 && !error)
    std::filesystem::remove(error_file(), error);
}

void Child::signal(int number) {
  if (running()) syscall(SYS_pidfd_send_signal, pidfd_, number, nullptr, 0);
}

void Child::reap() {
  if (!running()) return;
  rusage usage{};
  pid_t done = -1;
  do {
    done = wait4(pid_, &status_, 0, &usage);
  } while (done < 0 && errno == EINTR);
  const auto s = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  cpu_s_ = s(usage.ru_utime) + s(usage.ru_stime);
  pid_ = -1;
}

std::string Child::how_ended() const {
  if (WIFSIGNALED(status_)) return fmt::format("killed by signal {}", WTERMSIG(status_));
  return fmt::format("ended with status {}", WEXITSTATUS(status_));
}

int Child::exit_code() const { return WIFEXITED(status_) ? WEXITSTATUS(status_) : kExitFailure; }

double Child::cpu_s() const {
  if (!running()) return cpu_s_;
  std::ifstream file(fmt::format("/proc/{}/stat", pid_));
  std::string text((std::istreambuf_iterator<char>(file)), {});
  // The second field is the name in brackets and may hold spaces; utime and stime are the 14th and
  // 15th.
  std::istringstream fields(text.substr(std::min(text.size(), text.rfind(')') + 2)));
  std::string skipped;
  for (int i = 3; i < 14; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

void Child::measure_memory() {
  if (!running()) return;
  // Not wait4's figure: that one starts with the memory of the process that spawned it.
  std::ifstream file(fmt::format("/proc/{}/status", pid_));
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("VmHWM:", 0) == 0)
      peak_rss_mb_ = std::max(peak_rss_mb_, std::strtod(line.c_str() + 6, nullptr) / 1024);
  }
}

std::string Child::last_words() const {
  std::ifstream file(error_file());
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace muster::command
