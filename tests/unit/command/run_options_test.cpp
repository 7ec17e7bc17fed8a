#include "deploy/muster/run_options.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"

using namespace muster;
using namespace muster::command;
namespace fs = std::filesystem;

namespace {

mission::Mission pagoda() {
  return mission::Mission::load(MUSTER_SOURCE_DIR "/deploy/missions/pagoda.yaml");
}

}  // namespace

TEST_CASE("strategy and seed reach every process as overrides, after what --set says") {
  RunOptions options;
  options.set = {"radio.range_m=6"};
  CHECK(options.overrides() == options.set);
  options.strategy = "slei3d";
  options.seed = 7;
  CHECK(options.overrides() ==
        std::vector<std::string>{"radio.range_m=6", "strategy=slei3d", "seed=7"});
}

TEST_CASE("speed is max or a number above 0") {
  RunOptions options;
  CHECK(options.speed_factor() == 0);
  options.speed = "2.5";
  CHECK(options.speed_factor() == 2.5);
  for (const std::string wrong : {"0", "-1", "fast", "", "1x", "nan", "inf"}) {
    options.speed = wrong;
    INFO(wrong);
    CHECK_THROWS_AS(options.speed_factor(), BadInput);
  }
}

TEST_CASE("options that contradict each other or the mission are refused") {
  const mission::Mission mission = pagoda();
  const auto check = [&](const std::string& transport, const std::string& link,
                         const std::string& speed, std::vector<std::uint32_t> external,
                         double duration_s) {
    RunOptions options;
    options.transport = transport;
    options.link = link;
    options.speed = speed;
    options.external = std::move(external);
    options.duration_s = duration_s;
    options.validate(mission);
  };
  CHECK_NOTHROW(check("dds", "radio", "max", {}, 0));
  CHECK_NOTHROW(check("dds", "direct", "1", {3}, 60));
  CHECK_THROWS_AS(check("dds", "radio", "max", {}, -1), BadInput);
  CHECK_THROWS_AS(check("dds", "radio", "max", {}, std::nan("")), BadInput);
  CHECK_THROWS_AS(check("memory", "direct", "1", {}, 0), BadInput);
  CHECK_THROWS_AS(check("dds", "direct", "max", {}, 0), BadInput);
  CHECK_THROWS_AS(check("memory", "radio", "max", {3}, 0), BadInput);
  CHECK_THROWS_AS(check("dds", "radio", "max", {77}, 0), BadInput);
}

TEST_CASE("a script that names what this run cannot do is refused before anything starts") {
  mission::Mission mission = pagoda();
  mission.script = {{SimTime::from_s(5), "drain", RobotId{3}},
                    {SimTime::from_s(60), "kill", RobotId{3}}};
  RunOptions options;
  options.external = {4};
  CHECK_NOTHROW(options.validate(mission));
  options.external = {4, 3};
  CHECK_THROWS_WITH(options.validate(mission),
                    "--external 3: the script has a kill of robot 3 at 60 s, but its process is "
                    "yours to start and to kill");
  options.external.clear();
  options.link = std::string("direct");
  options.speed = std::string("1");
  CHECK_THROWS_WITH(options.validate(mission),
                    "--link direct: the mission's script has a kill at 60 s, which needs --link "
                    "radio");
  mission.script.pop_back();
  CHECK_NOTHROW(options.validate(mission));
}

TEST_CASE("an output directory is made with its logs, and says whether it was there before") {
  const fs::path dir = fs::temp_directory_path() / ("muster_out_" + std::to_string(getpid()));
  fs::remove_all(dir);
  CHECK(prepare_output(dir));
  CHECK(fs::is_directory(dir / "logs"));
  CHECK_FALSE(prepare_output(dir));
  std::ofstream(dir / "file") << "in the way";
  CHECK_THROWS_AS(prepare_output(dir / "file"), Failure);
  fs::remove_all(dir);
}

TEST_CASE("of a run that never began only its logs may stay") {
  const fs::path dir = fs::temp_directory_path() / ("muster_out_" + std::to_string(getpid()));
  for (const bool keep_logs : {true, false}) {
    prepare_output(dir);
    std::ofstream(dir / "station.db") << "half";
    std::ofstream(dir / "logs/world.log") << "why";
    remove_results(dir, keep_logs);
    CHECK_FALSE(fs::exists(dir / "station.db"));
    CHECK(fs::exists(dir / "logs/world.log") == keep_logs);
    CHECK(fs::exists(dir) == keep_logs);
  }
}
