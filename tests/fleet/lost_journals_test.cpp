// Robots and station whose disks are lost with them, in a whole flight in memory.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "common/core/log.h"
#include "common/mission/mission.h"
#include "deploy/muster/memory_fleet.h"

using namespace muster;

TEST_CASE(
    "an inspector, the explorer and the station that come back with nothing take part again") {
  const auto out =
      std::filesystem::temp_directory_path() / ("muster_lost_" + std::to_string(getpid()));
  std::filesystem::create_directories(out);
  const auto mission = mission::Mission::load(
      std::string(MUSTER_SOURCE_DIR) + "/tests/missions/pagoda_lost_journals.yaml", {"seed=1"});
  command::MemoryFleet fleet(mission, world::Scene::load(mission), command::make_process,
                             {.out = out});
  spdlog::set_level(spdlog::level::err);
  std::optional<std::string> end;
  while (!end) end = fleet.tick();
  const nlohmann::json summary = fleet.finish(*end);
  std::filesystem::remove_all(out);
  INFO(summary.dump(2));
  CHECK(summary.at("complete") == true);
  CHECK(summary.at("finish_rate") == 1.0);
  CHECK(summary.at("collisions") == 0);
  CHECK(summary.at("rule_violations") == 0);
  REQUIRE(summary.at("robots_lost").size() == 3);
  for (const auto& lost : summary.at("robots_lost")) CHECK(lost.at("journal_lost") == true);
  // What a disk took with it is no record that was forgotten; what had to be done again is named.
  CHECK(summary.at("records_lost").at("count") == 0);
  CHECK(summary.at("records_lost").at("journals") == 3);
  for (const auto& feature : summary.at("features_redone"))
    CHECK_FALSE(feature.at("again_s").is_null());
}
