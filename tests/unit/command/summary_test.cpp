#include "deploy/muster/summary.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"

using namespace muster;
using namespace muster::command;
using Catch::Contains;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

const fs::path kDir = fs::temp_directory_path() / ("muster_summary_" + std::to_string(getpid()));

}  // namespace

TEST_CASE("the exit status says complete, incomplete, or failed") {
  CHECK(exit_status({{"complete", true}}) == 0);
  CHECK(exit_status({{"complete", false}}) == 3);
  CHECK(exit_status(json::object()) == 3);
  CHECK(exit_status({{"complete", true}, {"failed", true}}) == 1);
}

TEST_CASE(
    "cost is counted per robot and simulated second, and is null where nothing was simulated") {
  json summary = {{"simulated_s", 200.0}};
  add_cost(summary, {.wall_s = 10, .cpu_s = 8, .agent_rss_mb = 41.5, .station_rss_mb = {}}, 5);
  CHECK(summary["real_time_factor"] == 20.0);
  CHECK(summary["cpu_ms_per_robot_s"] == 8.0);
  CHECK(summary["agent_rss_mb"] == 41.5);
  CHECK(summary["station_rss_mb"].is_null());

  json nothing = json::object();
  add_cost(nothing, {.wall_s = 0, .cpu_s = 1, .agent_rss_mb = {}, .station_rss_mb = {}}, 5);
  CHECK(nothing["real_time_factor"].is_null());
  CHECK(nothing["cpu_ms_per_robot_s"].is_null());
}

TEST_CASE("a summary is there whole or not at all") {
  fs::create_directories(kDir);
  write_summary(kDir, {{"complete", true}});
  write_summary(kDir, {{"complete", false}});
  CHECK(json::parse(std::ifstream(kDir / "summary.json")) == json{{"complete", false}});
  CHECK_FALSE(fs::exists(kDir / "summary.json.new"));
  fs::remove_all(kDir);
  CHECK_THROWS_AS(write_summary(kDir, {{"complete", true}}), Failure);
}

TEST_CASE("the table says who was lost, and shows a dash for what was not reached") {
  const json summary = {
      {"mission", "pagoda"},
      {"strategy", "slei3d"},
      {"seed", 7},
      {"complete", false},
      {"ended", "time limit"},
      {"t_s", nullptr},
      {"simulated_s", 3600.0},
      {"features_delivered", 149},
      {"features_total", 150},
      {"collisions", 0},
      {"robots_lost", {{{"robot", 3}, {"t_s", 12.34}, {"how", "killed by signal 9"}}}}};
  const std::string table = summary_table(summary);
  CHECK_THAT(table, Contains("pagoda · slei3d · seed 7"));
  CHECK_THAT(table, Contains("not complete (time limit)"));
  CHECK_THAT(table, Contains("149 of 150"));
  CHECK_THAT(table, Contains("3 at 12.3 s (killed by signal 9)"));
  CHECK_THAT(table, Contains("T                     –"));
  CHECK_THAT(summary_table({{"complete", true}}), Contains("robots lost           none"));
  // Where nothing could be lost or done again, nothing is said of it.
  CHECK_THAT(table, !Contains("records lost") && !Contains("inspected again"));
}

TEST_CASE("the table says what was forgotten, and what had to be done again") {
  const json summary = {{"records_lost", {{"count", 2}, {"journals", 7}, {"records", {}}}},
                        {"features_redone",
                         {{{"feature", 17}, {"lost_with", 3}, {"again_s", 88.0}},
                          {{"feature", 21}, {"lost_with", 3}, {"again_s", nullptr}}}}};
  const std::string table = summary_table(summary);
  CHECK_THAT(table, Contains("2 that a robot had said to hold   7 journals judged"));
  CHECK_THAT(table, Contains("inspected again       17, 21; 1 of them not yet"));
}
