// Two computers with a link between them that breaks: the station and a robot, each with its own
// network namespace. Needs the right to make namespaces (root); says so and passes otherwise.
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/programs.h"

namespace fs = std::filesystem;
using namespace muster::test;

namespace {

const std::string kPeer = MUSTER_FIELD_PEER;
const std::string kMission = std::string(MUSTER_SOURCE_DIR) + "/deploy/missions/pagoda.yaml";
constexpr double kCut_s = 14;

bool quiet(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

double monotonic_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void sleep_s(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

/// Namespaces `a` (10.77.0.1) and `b` (10.77.0.2) with a cable between them; gone at the end.
class Network {
 public:
  Network() {
    for (const std::string& name : {a_, b_}) made_ = made_ && quiet("ip netns add " + name);
    made_ = made_ && quiet(fmt::format(
                         "ip link add veth netns {} type veth peer name veth netns {}", a_, b_));
    int host = 0;
    for (const std::string& name : {a_, b_}) {
      made_ =
          made_ && quiet(fmt::format("ip -n {} address add 10.77.0.{}/24 dev veth", name, ++host));
      made_ = made_ && quiet(fmt::format("ip -n {} link set veth up", name));
      made_ = made_ && quiet(fmt::format("ip -n {} link set lo up", name));
    }
  }
  ~Network() {
    for (const std::string& name : {a_, b_}) quiet("ip netns del " + name);
  }
  bool made() const { return made_; }
  void link(bool up) const {
    REQUIRE(quiet(fmt::format("ip -n {} link set veth {}", a_, up ? "up" : "down")));
  }
  const std::string& a() const { return a_; }
  const std::string& b() const { return b_; }

 private:
  std::string a_ = fmt::format("muster-a-{}", getpid()), b_ = fmt::format("muster-b-{}", getpid());
  bool made_ = true;
};

/// A peer in a namespace; ended and reaped with the object.
class Peer {
 public:
  Peer(const std::string& netns, const std::string& arguments, const fs::path& heard)
      : heard_(heard),
        pid_(start(fmt::format("ip netns exec {} {} {} {} > {} 2>{}.err", netns, kPeer, kMission,
                               arguments, heard.string(), heard.string()))) {}
  ~Peer() {
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }
  /// An operator asks the station.
  void ask_to_hold() const { kill(pid_, SIGUSR1); }
  /// When it first heard `topic` (empty: anything) after a moment; negative: never.
  double first_s(double after_s, const std::string& topic = "") const {
    std::ifstream file(heard_);
    for (std::string line; std::getline(file, line);) {
      std::istringstream words(line);
      std::string heard, what;
      double t_s = 0;
      if (!(words >> heard >> t_s >> what) || heard != "heard") continue;  // a line of the log
      if (t_s > after_s && (topic.empty() || what == topic)) return t_s;
    }
    return -1;
  }
  /// Heard `topic` (empty: anything) after `after_s`, waited for at most `patience_s`.
  bool hears(double after_s, double patience_s, const std::string& topic = "") const {
    const double end_s = monotonic_s() + patience_s;
    while (first_s(after_s, topic) < 0) {
      if (monotonic_s() > end_s) return false;
      sleep_s(0.05);
    }
    return true;
  }

 private:
  fs::path heard_;
  pid_t pid_;
};

}  // namespace

TEST_CASE("a station and a robot exchange again within a second of a link that was cut for 14 s") {
  const auto [vendor, profile, domain] = GENERATE(table<std::string, std::string, int>(
      {{"cyclonedds", "wifi-unicast", 52}, {"fastdds", "wired", 54}}));
  const Network network;
  if (!network.made()) {
    WARN("skipped: network namespaces cannot be made here (needs root and iproute2)");
    return;
  }
  const Place place;
  {
    const double start_s = monotonic_s();
    const auto peer = [&](const std::string& netns, int id, int self, int other) {
      return std::make_unique<Peer>(
          netns,
          fmt::format("{} {} {} {} 10.77.0.{} 10.77.0.{} {} {}", id, vendor, profile, domain, self,
                      other, 2 * self, start_s),
          place.path / fmt::format("heard-{}", id));
    };
    const auto station = peer(network.a(), 1, 1, 2), robot = peer(network.b(), 2, 2, 1);
    REQUIRE(station->hears(0, 20));
    REQUIRE(robot->hears(0, 20));
    sleep_s(2);

    network.link(false);
    const double cut_s = monotonic_s();
    sleep_s(kCut_s / 2);
    station->ask_to_hold();
    sleep_s(kCut_s / 2);
    CHECK(station->first_s(cut_s + 0.5) < 0);
    CHECK(robot->first_s(cut_s + 0.5) < 0);

    network.link(true);
    const double back_s = monotonic_s();
    for (const Peer* who : {station.get(), robot.get()}) {
      CHECK(who->hears(back_s - 0.2, 10));
      const double after_s = who->first_s(back_s - 0.2) - back_s;
      INFO(vendor << " " << profile << ": heard again after " << after_s << " s");
      CHECK(after_s < 1);
    }
    // Records too: what the station was told meanwhile reaches the robot.
    CHECK(robot->hears(back_s - 0.2, 5, "status"));
    const double record_s = robot->first_s(back_s - 0.2, "status") - back_s;
    INFO(vendor << " " << profile << ": the request was there after " << record_s << " s");
    CHECK(record_s < 1);
  }
}
