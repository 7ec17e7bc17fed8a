// The real programs fly a part of `pagoda`: the trace does not depend on who carries the messages,
// nor on load, nor on the order in which they arrive; without the simulated radio robots hear each
// other; a lost robot does not end the mission.
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/geometry/pose.h"
#include "tests/programs.h"

namespace fs = std::filesystem;
using namespace muster::test;

namespace {

const std::string kMuster = std::string(MUSTER_BIN_DIR) + "/muster";
const std::string kPagoda = std::string(MUSTER_SOURCE_DIR) + "/deploy/missions/pagoda.yaml";

/// Keeps both cores busy while it lives.
class Load {
 public:
  Load() {
    for (pid_t& pid : pids_) {
      pid = fork();
      if (pid == 0) {
        for (std::atomic<unsigned> i = 0;;) ++i;
      }
    }
  }
  ~Load() {
    for (const pid_t pid : pids_) {
      kill(pid, SIGKILL);
      waitpid(pid, nullptr, 0);
    }
  }

 private:
  std::array<pid_t, 2> pids_{};
};

}  // namespace

TEST_CASE("the same flight by either vendor, mixed, in memory, under load and out of order") {
  const Place place;
  const auto fly = [&](const std::string& name, const std::string& how,
                       const std::string& environment = "") {
    const Ended run = shell(fmt::format(
        "{} timeout 250 {} run {} --seed 1 --duration 40 --no-report --trace --out {} {}",
        environment, kMuster, kPagoda, place / name, how));
    INFO(name << ": " << run.output);
    CHECK(run.status == 3);
    return summary_of(place / name)["trace_hash"].get<std::string>();
  };
  const auto first_difference = [&](const std::string& name) {
    return shell(fmt::format("diff {} {} | head -3", place / "memory/trace.csv",
                             place / (name + "/trace.csv")))
        .output;
  };
  const std::string trace = fly("memory", "--transport memory");
  CHECK(fly("again", "--transport memory") == trace);
  for (const char* dds : {"cyclonedds", "fastdds", "mixed"}) {
    const std::string other = fly(dds, fmt::format("--dds {}", dds));
    INFO(dds << " parts at:\n" << first_difference(dds));
    CHECK(other == trace);
  }
  CHECK(fly("shuffled", "", "MUSTER_DDS_SHUFFLE=1") == trace);
  const Load load;
  CHECK(fly("busy", "") == trace);
}

TEST_CASE("robots and station that die come back with what they kept, the same over DDS") {
  const Place place;
  const std::string mission =
      std::string(MUSTER_SOURCE_DIR) + "/tests/missions/pagoda_restart.yaml";
  const auto fly = [&](const std::string& name, const std::string& how) {
    const Ended run =
        shell(fmt::format("timeout 250 {} run {} --seed 1 --duration 50 --no-report --out {} {}",
                          kMuster, mission, place / name, how));
    INFO(name << ": " << run.output);
    CHECK(run.status == 3);
    return summary_of(place / name);
  };
  const auto memory = fly("memory", "--transport memory"), mixed = fly("mixed", "--dds mixed");
  CHECK(memory["trace_hash"] == mixed["trace_hash"]);
  CHECK(mixed["collisions"] == 0);
  REQUIRE(mixed["robots_lost"].size() == 5);
  for (const auto& lost : mixed["robots_lost"]) CHECK_FALSE(lost["revived_s"].is_null());
  // By the journals that the dead left behind and those of the end, against all that was said.
  for (const auto& summary : {memory, mixed}) {
    CHECK(summary["records_lost"]["count"] == 0);
    CHECK(summary["records_lost"]["journals"] == 5);
  }
  for (const char* log : {"gcs-1", "agent-2", "agent-3", "agent-4", "agent-5"}) {
    CAPTURE(log);
    const std::string file = place / fmt::format("mixed/logs/{}.log", log);
    CHECK(shell("grep -E 'goes on with [1-9][0-9]* records' " + file).status == 0);
  }
}

TEST_CASE("every kind of fault, the same over DDS, and nobody touches anything") {
  const Place place;
  const auto fly = [&](const std::string& name, const std::string& how) {
    const Ended run = shell(fmt::format(
        "timeout 250 {} run {} --faults {}/tests/missions/faults.yaml --seed 1 --duration 50 "
        "--no-report --out {} {}",
        kMuster, kPagoda, MUSTER_SOURCE_DIR, place / name, how));
    INFO(name << ": " << run.output);
    CHECK(run.status == 3);
    return summary_of(place / name);
  };
  const auto memory = fly("memory", "--transport memory"), mixed = fly("mixed", "--dds mixed");
  CHECK(memory["trace_hash"] == mixed["trace_hash"]);
  CHECK(memory["air"]["dropped"] == mixed["air"]["dropped"]);
  CHECK(mixed["collisions"] == 0);
  for (const char* reason : {"jam", "cut", "loss", "paused", "dead", "scripted"}) {
    CAPTURE(reason);
    CHECK(mixed["air"]["dropped"][reason] > 0);
  }
  const std::string log = place / "mixed/logs/agent-3.log";
  CHECK(shell("grep 'disk is full; flying on' " + log).status == 0);
  CHECK(shell("grep 'written again, and up to date' " + log).status == 0);
}

TEST_CASE("robots and station killed by SIGKILL from outside are started again and go on") {
  const Place place;
  const pid_t launcher =
      start(fmt::format("timeout 250 {} run {} --seed 1 --duration 90 --speed 12 --restart 3 "
                        "--no-report --out {} > {}.out 2>&1",
                        kMuster, kPagoda, place / "run", place / "run"));
  // Each when it has something to lose; by its number in the order of starting, oldest first.
  const auto flown_s = [&] {
    const Ended last = shell(fmt::format("tail -n 1 {}", place / "run/tracks.csv"));
    return last.status == 0 ? std::atof(last.output.c_str()) : 0.0;
  };
  const auto kill_when = [&](double t_s, int robot) {
    for (int i = 0; i < 4000 && flown_s() < t_s; ++i) usleep(20'000);
    REQUIRE(flown_s() >= t_s);
    CHECK(shell(fmt::format("pkill -KILL -f -- '--out {} .*--id {}( |$)'", place / "run", robot))
              .status == 0);
  };
  kill_when(10, 3);
  kill_when(20, 1);
  kill_when(30, 2);
  kill_when(40, 5);
  int status = 0;
  waitpid(launcher, &status, 0);
  INFO(shell("tail -n 30 " + (place / "run.out")).output);
  CHECK(WEXITSTATUS(status) == 3);
  const auto summary = summary_of(place / "run");
  CHECK(summary["ended"] == "duration reached");
  CHECK(summary["collisions"] == 0);
  CHECK(summary["records_lost"]["count"] == 0);
  CHECK(summary["records_lost"]["journals"] == 5);
  CHECK(summary["features_redone"].empty());
  REQUIRE(summary["robots_lost"].size() == 4);
  for (const auto& lost : summary["robots_lost"]) {
    CHECK(lost["how"] == "killed by signal 9");
    CHECK_FALSE(lost["revived_s"].is_null());
  }
  for (const char* log : {"gcs-1", "agent-2", "agent-3", "agent-5"}) {
    CAPTURE(log);
    const std::string file = place / fmt::format("run/logs/{}.log", log);
    CHECK(shell("grep -E 'goes on with [1-9][0-9]* records' " + file).status == 0);
  }
  CHECK(summary["map_coverage"].get<double>() > 0.2);
}

TEST_CASE(
    "what a robot that never comes back had inspected and told nobody is named as to be redone") {
  const Place place;
  const auto fly = [&](const std::string& name, const std::string& how) {
    const Ended run = shell(fmt::format(
        "timeout 250 {} run {} --seed 1 --duration 400 --transport memory --no-report --out {} {}",
        kMuster, kPagoda, place / name, how));
    INFO(run.output);
    CHECK(run.status == 3);
  };
  fly("whole", "");
  // Out of everybody's hearing around that second.
  const auto alone = [&](double t_s, int robot) {
    std::map<int, std::map<int, muster::Vec3>> at;  // by second and robot
    std::ifstream tracks(place / "whole/tracks.csv");
    for (std::string line; std::getline(tracks, line);) {
      double t = 0, x = 0, y = 0, z = 0;
      int id = 0;
      if (std::sscanf(line.c_str(), "%lf,%d,%lf,%lf,%lf", &t, &id, &x, &y, &z) == 5 &&
          std::abs(t - t_s) < 2)
        at[static_cast<int>(t)][id] = {x, y, z};
    }
    return std::ranges::all_of(at, [&](const auto& second) {
      return std::ranges::all_of(second.second, [&](const auto& other) {
        return other.first == robot || (other.second - second.second.at(robot)).norm() > 6;
      });
    });
  };
  // An inspection whose inspector took it along for a while before it met anybody.
  std::map<int, nlohmann::json> carried;
  std::optional<nlohmann::json> prey;
  std::ifstream events(place / "whole/events.jsonl");
  for (std::string line; !prey && std::getline(events, line);) {
    const auto event = nlohmann::json::parse(line);
    if (event["event"] == "inspected") carried[event["feature"]] = event;
    if (event["event"] != "delivered") continue;
    const auto& from = carried.at(event["feature"]);
    if (event["t_s"].get<double>() - from["t_s"].get<double>() > 1 &&
        alone(from["t_s"].get<double>(), from["robot"].get<int>()))
      prey = from;
  }
  REQUIRE(prey);
  std::ofstream(place / "faults.yaml")
      << fmt::format("script: [{{at_s: {}, verb: kill, robot: {}}}]\n",
                     (*prey)["t_s"].get<double>() + 0.1, (*prey)["robot"].get<int>());
  fly("lost", "--faults " + (place / "faults.yaml"));
  const auto summary = summary_of(place / "lost");
  REQUIRE(summary["robots_lost"].size() == 1);
  CHECK(summary["robots_lost"][0]["revived_s"].is_null());
  CHECK(summary["records_lost"]["count"] == 0);
  REQUIRE(summary["features_redone"].size() == 1);
  CHECK(summary["features_redone"][0]["feature"] == (*prey)["feature"]);
  CHECK(summary["features_redone"][0]["lost_with"] == (*prey)["robot"]);
}

TEST_CASE("without the simulated radio robots hear each other, and the station's map grows") {
  const Place place;
  const Ended run =
      shell(fmt::format("timeout 100 {} run {} --seed 1 --duration 30 --link direct --speed 1 "
                        "--no-report "
                        "--out {}",
                        kMuster, kPagoda, place / "direct"));
  INFO(run.output);
  CHECK(run.status == 3);
  const auto summary = summary_of(place / "direct");
  CHECK(summary["collisions"] == 0);
  CHECK(summary["robots_lost"].empty());
  // Who explores is not the station: what it knows of the map came over the air.
  CHECK(summary["map_coverage"].get<double>() > 0.05);
  CHECK(fs::file_size(place / "direct/map.bt") > 1000);
}
