#include "commsim/air_log.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/core/error.h"

using namespace muster;
using namespace muster::commsim;

namespace {

std::string path() {
  return (std::filesystem::temp_directory_path() / ("air_" + std::to_string(getpid()) + ".csv"))
      .string();
}

std::vector<std::string> lines_of(const std::string& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace

TEST_CASE("what was heard and lost is a row for its two seconds, in order") {
  AirLog log(path(), {RobotId{3}, RobotId{5}, RobotId{9}});
  log.advance(SimTime::from_s(0.1));
  log.heard(0, 1, 100);
  log.heard(0, 1, 50);
  log.advance(SimTime::from_s(1.9));
  log.dropped(2, 0, 70, Drop::kLoss);
  log.advance(SimTime::from_s(2.0));
  log.heard(1, 0, 8);
  log.finish();
  CHECK(lines_of(path()) ==
        std::vector<std::string>{
            "t_s,from,to,heard,heard_bytes,dropped_bytes,range,wall,dead,scripted,loss,airtime,"
            "jam,cut,paused,pose",
            "0,3,5,2,150,0,0,0,0,0,0,0,0,0,0,0", "0,9,3,0,0,70,0,0,0,0,1,0,0,0,0,0",
            "2,5,3,1,8,0,0,0,0,0,0,0,0,0,0,0"});
  std::filesystem::remove(path());
}

TEST_CASE("silence takes no rows, and its drops are not forgotten") {
  AirLog log(path(), {RobotId{1}, RobotId{2}});
  for (int k = 0; k < 1000; ++k) {
    log.advance(SimTime::from_s(0.1 * k));
    log.dropped(0, 1, 10, Drop::kRange);
    if (k == 500) log.heard(0, 1, 7);
    log.dropped(1, 0, 1, Drop::kDead);
  }
  log.finish();
  CHECK(lines_of(path()) ==
        std::vector<std::string>{
            "t_s,from,to,heard,heard_bytes,dropped_bytes,range,wall,dead,scripted,loss,airtime,"
            "jam,cut,paused,pose",
            "50,1,2,1,7,5200,520,0,0,0,0,0,0,0,0,0", "98,1,2,0,0,4800,480,0,0,0,0,0,0,0,0,0",
            "98,2,1,0,0,1000,0,0,1000,0,0,0,0,0,0,0"});
  std::filesystem::remove(path());
}

TEST_CASE("a place that cannot be written to is told") {
  CHECK_THROWS_AS(AirLog("/nowhere/air.csv", {}), Failure);
}
