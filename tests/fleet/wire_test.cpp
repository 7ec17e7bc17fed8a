#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/free_domain.h"

extern char** environ;

namespace {

/// A child process that we talk with by lines. Ends with us: when its stdin closes, or else killed
/// by its pid.
class Peer {
 public:
  explicit Peer(std::vector<std::string> args) {
    args.insert(args.begin(), MUSTER_BIN_DIR "/wire_peer");
    int in[2], out[2];
    REQUIRE(pipe2(in, O_CLOEXEC) == 0);
    REQUIRE(pipe2(out, O_CLOEXEC) == 0);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, in[0], 0);
    posix_spawn_file_actions_adddup2(&files, out[1], 1);
    std::vector<char*> argv;
    argv.reserve(args.size() + 1);
    for (std::string& a : args) argv.push_back(a.data());
    argv.push_back(nullptr);
    REQUIRE(posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), environ) == 0);
    posix_spawn_file_actions_destroy(&files);
    close(in[0]);
    close(out[1]);
    stdin_ = in[1];
    stdout_ = out[0];
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  ~Peer() {
    if (pid_ > 0) kill(pid_, SIGKILL);
    finish();
    close(stdout_);
  }

  /// What it says next; empty when it has ended, or says nothing for longer than its own limits.
  std::string line() {
    std::size_t end = 0;
    while ((end = heard_.find('\n')) == std::string::npos) {
      pollfd readable{.fd = stdout_, .events = POLLIN, .revents = 0};
      char text[512];
      const ssize_t n =
          poll(&readable, 1, kPatience_ms) == 1 ? read(stdout_, text, sizeof text) : 0;
      if (n <= 0) return {};
      heard_.append(text, static_cast<std::size_t>(n));
    }
    std::string l = heard_.substr(0, end);
    heard_.erase(0, end + 1);
    return l;
  }
  /// Exit status after closing its stdin; -1 when it had to be killed.
  int finish() {
    if (stdin_ >= 0) close(std::exchange(stdin_, -1));
    if (pid_ <= 0) return -1;
    for (pollfd ended{.fd = stdout_, .events = 0, .revents = 0}; (ended.revents & POLLHUP) == 0;) {
      if (poll(&ended, 1, kPatience_ms) != 1) kill(pid_, SIGKILL);
    }
    int status = -1;
    waitpid(std::exchange(pid_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  static constexpr int kPatience_ms = 150'000;
  pid_t pid_ = -1;
  int stdin_ = -1, stdout_ = -1;
  std::string heard_;
};

std::set<std::string> files_in(const char* directory) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    if (name.find("fast") != std::string::npos || name.find("cyclone") != std::string::npos) {
      names.insert(name);
    }
  }
  return names;
}

void exchange(const std::string& hub_vendor) {
  const std::string domain = std::to_string(muster::test::free_domain());
  Peer hub({hub_vendor, domain, "hub", "1,2,3,4"});
  REQUIRE(hub.line() == "open");
  Peer cyclone({"cyclonedds", domain, "agent", "1"});
  Peer fast({"fastdds", domain, "agent", "2"});
  REQUIRE(cyclone.line() == "complete");
  REQUIRE(fast.line() == "complete");
  std::set<std::string> served = {hub.line(), hub.line()};
  REQUIRE(served == std::set<std::string>{"complete 1", "complete 2"});

  Peer late_cyclone({"cyclonedds", domain, "agent", "3"});
  Peer late_fast({"fastdds", domain, "agent", "4"});
  REQUIRE(late_cyclone.line() == "complete");
  REQUIRE(late_fast.line() == "complete");
  served = {hub.line(), hub.line()};
  REQUIRE(served == std::set<std::string>{"complete 3", "complete 4"});
  for (Peer* p : {&cyclone, &fast, &late_cyclone, &late_fast, &hub}) CHECK(p->finish() == 0);
}

TEST_CASE(
    "every topic crosses between the vendors, 100 B to 1 MB, nothing lost, nobody overheard") {
  const std::set<std::string> before = files_in("/dev/shm");
  SECTION("Cyclone hub") { exchange("cyclonedds"); }
  SECTION("Fast hub") { exchange("fastdds"); }
  CHECK(files_in("/dev/shm") == before);
}

TEST_CASE("a second hub is told that the domain is taken") {
  const std::string domain = std::to_string(muster::test::free_domain());
  Peer hub({"cyclonedds", domain, "hub", "1"});
  REQUIRE(hub.line() == "open");
  Peer second({"fastdds", domain, "hub", "1"});
  CHECK(second.line().find("DDS domain " + domain + " is in use") != std::string::npos);
  CHECK(second.finish() == 1);
}

}  // namespace
