#include "deploy/muster/pose_log.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "common/core/error.h"

using namespace muster;
using command::PoseLog;

namespace {

mission::Mission mission_of(std::initializer_list<std::uint32_t> ids) {
  mission::Mission m;
  for (const std::uint32_t id : ids) {
    mission::RobotConfig robot;
    robot.id = RobotId{id};
    m.fleet.push_back(robot);
  }
  return m;
}

/// A log with this text, gone at the end.
class LogFile {
 public:
  explicit LogFile(const std::string& text) { std::ofstream(path_) << text; }
  ~LogFile() { std::filesystem::remove(path_); }
  PoseLog load() const { return PoseLog::load(path_.string(), mission_of({1, 2, 7})); }
  std::string complaint() const {
    try {
      load();
    } catch (const BadInput& e) {
      const std::string all = e.what();
      REQUIRE(all.starts_with(path_.string() + ":"));
      return all.substr(path_.string().size());
    }
    return "none";
  }

 private:
  std::filesystem::path path_ = std::filesystem::temp_directory_path() /
                                ("muster_poses_" + std::to_string(getpid()) + ".csv");
};

}  // namespace

TEST_CASE("a log of poses names its columns, in any order, and other columns are passed over") {
  const LogFile file("robot,colour,z,y,x,t_s\r\n7,red,3,2,1,10\r\n\r\n2,blue,6,5,4,12.5\r\n");
  const PoseLog log = file.load();
  CHECK(log.begin_s() == 10);
  CHECK(log.end_s() == 12.5);
  CHECK(log.robots() == std::set{RobotId{2}, RobotId{7}});
  REQUIRE(log.at(10).size() == 1);
  CHECK(log.at(10)[0].robot == RobotId{7});
  CHECK(log.at(10)[0].pose.p == Vec3(1, 2, 3));
}

TEST_CASE("between two rows a robot is on the straight line and turns the short way") {
  const LogFile file("t_s,robot,x,y,z,yaw_rad\n0,1,0,0,1,3\n1,1,2,4,1,-3\n");
  const auto half = file.load().at(0.5);
  REQUIRE(half.size() == 1);
  CHECK(half[0].pose.p.isApprox(Vec3(1, 2, 1)));
  CHECK(std::abs(half[0].pose.yaw_rad) == Approx(std::numbers::pi));
}

TEST_CASE("where rows are missing nobody knows where a robot is") {
  const LogFile file("t_s,robot,x,y,z\n1,1,0,0,1\n2,1,1,0,1\n9,1,2,0,1\n");
  const PoseLog log = file.load();
  CHECK(log.at(0.9).empty());
  CHECK(log.at(1.5).size() == 1);
  CHECK(log.at(5).empty());
  CHECK(log.at(9).size() == 1);
  CHECK(log.at(9.1).empty());
}

TEST_CASE("what is wrong in a log of poses is told with its line") {
  const auto complaint = [](const std::string& text) { return LogFile(text).complaint(); };
  const std::string header = "t_s,robot,x,y,z\n";
  CHECK_THAT(complaint(""), Catch::StartsWith(":1: is empty"));
  CHECK(complaint("t_s,robot,x,y\n") == ":1: the column z is missing");
  CHECK_THAT(complaint(header), Catch::EndsWith("there are no poses"));
  CHECK(complaint(header + "0,1,0,0\n") == ":2: has 4 cells, and the first line names 5 columns");
  CHECK(complaint(header + "0,1,0,0,1\n0.1,1,0,north,1\n") == ":3: y: 'north' is not a number");
  CHECK(complaint(header + "0,1,0,0,nan\n") == ":2: z: 'nan' is not a number");
  CHECK(complaint(header + "0,3,0,0,1\n") == ":2: robot: the mission has no robot 3");
  CHECK(complaint(header + "0,1.5,0,0,1\n") == ":2: robot: the mission has no robot 1.5");
  CHECK(complaint(header + "1,1,0,0,1\n1,2,0,0,1\n1,1,0,0,1\n") ==
        ":4: t_s: 1 is not after 1, the row before of the same robot");
}
