// The command with real processes: what it promises about traces, deaths, ends and bad input.
// Robots hop (hopper.h).
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/free_domain.h"
#include "tests/programs.h"

namespace fs = std::filesystem;
using namespace muster::test;

namespace {

const std::string kMuster = std::string(MUSTER_HOPPERS) + "/muster";
const std::string kPagoda = std::string(MUSTER_SOURCE_DIR) + "/deploy/missions/pagoda.yaml";

Ended command(const std::string& arguments) {
  return shell("timeout 300 " + kMuster + " " + arguments);
}

std::size_t lines_in(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// `muster run` in the background, watched through its events.
class Running {
 public:
  Running(const std::string& dir, const std::string& arguments)
      : dir_(dir),
        pid_(start(fmt::format("{} run {} --speed 10 --out {} {} > {}.out 2>&1", kMuster, kPagoda,
                               dir, arguments, dir))) {
    for (int i = 0; i < 2400 && !flies(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    REQUIRE(flies());
  }

  void signal(int number) const { kill(pid_, number); }
  /// SIGKILL to the one child whose command line has this.
  void kill_child(const std::string& what) const {
    REQUIRE(shell(fmt::format("pkill -KILL -P {} -f -- '{}'", pid_, what)).status == 0);
  }
  void await_child(const std::string& what) const {
    for (int i = 0; i < 12000 && !has_child(what); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    REQUIRE(has_child(what));
  }
  void kill_child_once_there(const std::string& what) const {
    await_child(what);
    kill_child(what);
  }
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    return WEXITSTATUS(status);
  }
  std::string output() const { return text_of(dir_ + ".out"); }
  bool left_nothing() const { return shell("pgrep -f -- '[-]-out " + dir_ + "'").status != 0; }

 private:
  bool has_child(const std::string& what) const {
    return shell(fmt::format("pgrep -P {} -f -- '{}'", pid_, what)).status == 0;
  }
  /// The first line of progress is out and so the first second is under way.
  bool flies() const { return output().find(" s  map") != std::string::npos; }

  std::string dir_;
  pid_t pid_;
};

/// Five seconds of a machine of our own: more where others want the same cores.
std::chrono::duration<double> five_seconds() {
  double load = 0;
  getloadavg(&load, 1);
  return std::chrono::duration<double>(
      5 * std::max(1.0, load / static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN))));
}

}  // namespace

TEST_CASE("every transport gives the same trace, also when arrivals are late and out of order") {
  const Place place;
  const std::string common = "run " + kPagoda + " --duration 8 --no-report --out ";
  CHECK(command(common + place / "memory" + " --transport memory").status == 3);
  const auto trace = summary_of(place / "memory")["trace_hash"];
  CHECK(trace.get<std::string>().size() == 16);
  for (const char* dds : {"cyclonedds", "fastdds", "mixed"}) {
    INFO(dds);
    const Ended run = command(common + place / dds + " --dds " + dds);
    INFO(run.output);
    CHECK(run.status == 3);
    CHECK(summary_of(place / dds)["trace_hash"] == trace);
  }
  CHECK(shell("MUSTER_DDS_SHUFFLE=5 timeout 300 " + kMuster + " " + common + place / "shuffled")
            .status == 3);
  CHECK(summary_of(place / "shuffled")["trace_hash"] == trace);
}

TEST_CASE("a scripted kill and revival give the same trace over DDS and in memory") {
  const Place place;
  // A mission file finds scenes and vehicles beside its folder.
  fs::create_directories(place / "missions");
  for (const char* name : {"scenes", "vehicles"}) {
    fs::create_directory_symlink(std::string(MUSTER_SOURCE_DIR) + "/deploy/" + name, place / name);
  }
  const std::string mission = place / "missions/mission.yaml";
  fs::copy_file(kPagoda, mission);
  std::ofstream(mission, std::ios::app) << "\nscript:\n  - {at_s: 2, verb: kill, robot: 3}\n"
                                           "  - {at_s: 4, verb: revive, robot: 3}\n";
  const std::string common = "run " + mission + " --duration 6 --no-report --out ";
  const Ended memory = command(common + place / "memory" + " --transport memory");
  INFO(memory.output);
  REQUIRE(memory.status == 3);
  const Ended dds = command(common + place / "dds");
  INFO(dds.output);
  CHECK(dds.status == 3);
  CHECK(summary_of(place / "dds")["trace_hash"] == summary_of(place / "memory")["trace_hash"]);
  CHECK(summary_of(place / "dds")["robots_lost"][0]["robot"] == 3);
}

TEST_CASE(
    "the mission goes on without an agent that was killed, and the summary says who and when") {
  const Place place;
  Running run(place / "run", "--duration 40");
  run.kill_child("muster-agent .*--id 3");
  CHECK(run.wait() == 3);
  const auto summary = summary_of(place / "run");
  CHECK(summary["ended"] == "duration reached");
  REQUIRE(summary["robots_lost"].size() == 1);
  CHECK(summary["robots_lost"][0]["robot"] == 3);
  CHECK(summary["robots_lost"][0]["how"] == "killed by signal 9");
  CHECK(summary["robots_lost"][0]["t_s"].get<double>() < 40);
  CHECK(run.left_nothing());
}

TEST_CASE("who is killed on its way back, or together with everybody else, is started again") {
  const Place place;
  Running run(place / "run", "--duration 60 --restart 2");
  run.kill_child("muster-agent .*--id 3");
  run.kill_child_once_there("muster-agent .*--id 3 --epoch 2");
  run.kill_child_once_there("muster-agent .*--id 3 --epoch 3");
  run.await_child("muster-agent .*--id 3 --epoch 4");
  run.kill_child("--id [0-9]+");
  run.await_child("muster-agent .*--id 3 --epoch 5");
  CHECK(run.wait() == 3);
  INFO(run.output());
  const auto summary = summary_of(place / "run");
  CHECK(summary["ended"] == "duration reached");
  CHECK(summary["robots_lost"].size() >= 5);
  for (const auto& lost : summary["robots_lost"]) CHECK_FALSE(lost["revived_s"].is_null());
  CHECK(run.left_nothing());
}

TEST_CASE(
    "when the world or the radio is killed, everybody ends within 5 s and the message names it") {
  for (const char* who : {"world", "commsim"}) {
    const Place place;
    Running run(place / "run", "--duration 600");
    const auto start = std::chrono::steady_clock::now();
    run.kill_child(fmt::format("muster-{} ", who));
    CHECK(run.wait() == 1);
    CHECK(std::chrono::steady_clock::now() - start < five_seconds());
    CHECK(run.output().find(fmt::format("the {} was lost (killed by signal 9)", who)) !=
          std::string::npos);
    CHECK(summary_of(place / "run")["complete"] == false);
    CHECK(run.left_nothing());
  }
}

TEST_CASE("Ctrl-C stops every process and still writes the summary") {
  const Place place;
  Running run(place / "run", "--duration 600");
  run.signal(SIGINT);
  CHECK(run.wait() == 3);
  CHECK(summary_of(place / "run")["ended"] == "interrupted");
  CHECK(fs::exists(place / "run/station.db"));
  CHECK(fs::exists(place / "run/report.html"));
  CHECK(run.left_nothing());
}

TEST_CASE("every child dies with a launcher that was killed") {
  const Place place;
  Running run(place / "run", "--duration 600");
  run.signal(SIGKILL);
  run.wait();
  for (int i = 0; i < 600 && !run.left_nothing(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  CHECK(run.left_nothing());
}

TEST_CASE("muster ctl reaches the world of a running mission, and says when there is none") {
  const Place place;
  Running run(place / "run", "--duration 40");
  CHECK(command("ctl " + place / "run" + " hold --robot 3").status == 0);
  CHECK(command("ctl " + place / "run" + " abort").status == 0);
  CHECK(command("ctl " + place / "run" + " abort --robot 99").status == 2);
  CHECK(run.wait() == 3);
  const std::string events = text_of(place / "run/events.jsonl");
  CHECK(events.find("\"verb\":\"hold\"") != std::string::npos);
  CHECK(events.find("\"verb\":\"abort\"") != std::string::npos);
  CHECK(command("ctl " + place / "run" + " abort").status == 1);
}

TEST_CASE(
    "bad input is one line and status 2, a failing place one line and status 1, and nothing is "
    "left behind") {
  const Place place;
  const std::string nothing = place / "nothing";
  const auto [arguments, status] = GENERATE_COPY(table<std::string, int>({
      {"run nowhere.yaml", 2},
      {"run " + kPagoda + " --strategy guess", 2},
      {"run " + kPagoda + " --dds opendds", 2},
      {"run " + kPagoda + " --set radio.rnge_m=3", 2},
      {"run " + kPagoda + " --speed 0", 2},
      {"run " + kPagoda + " --external 77", 2},
      {"run " + kPagoda + " --domain 99", 2},
      {"run " + kPagoda + " --link direct --transport memory", 2},
      {"run " + kPagoda + " --out /proc/muster", 1},
      {"ctl " + nothing + " abort", 1},
      {"ctl " + nothing + " jump", 2},
      {"fly", 2},
  }));
  INFO(arguments);
  const Ended run = command(arguments);
  INFO(run.output);
  CHECK(run.status == status);
  CHECK(lines_in(run.output) == 1);
}

TEST_CASE("a domain or a directory in use is named") {
  const Place place;
  const std::string taken = std::to_string(free_domain());
  Running run(place / "run", "--duration 600 --domain " + taken);
  const Ended domain =
      command("run " + kPagoda + " --domain " + taken + " --out " + place / "other");
  CHECK(domain.status == 1);
  CHECK(domain.output.find(taken + " is in use") != std::string::npos);
  const Ended dir = command("run " + kPagoda + " --out " + place / "run");
  CHECK(dir.status == 1);
  CHECK(dir.output.find("another run is using this directory") != std::string::npos);
  run.signal(SIGINT);
  CHECK(run.wait() == 3);
}
