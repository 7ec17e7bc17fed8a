#include "deploy/muster/doctor.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"

using namespace muster;
using namespace muster::command;
using Catch::Contains;
using Verdict = Check::Verdict;
namespace fs = std::filesystem;

TEST_CASE("the doctor finds this computer's loopback, ports, buffers and clock") {
  CHECK_THAT(to_text(check_interfaces(), false), Contains("127.0.0.1"));
  CHECK(taken_domains().size() < 100);
  CHECK_THAT(to_text(check_buffers(), false), Contains("net.core.rmem_max is"));
  CHECK_THAT(to_text(check_clock(), false), Contains("monotonic clock from"));
  CHECK_FALSE(check_processes().empty());
}

TEST_CASE("shared memory that killed processes left is counted, and nothing else is") {
  const fs::path folder = fs::temp_directory_path() / "muster_doctor_shm";
  fs::remove_all(folder);
  fs::create_directories(folder);
  std::ofstream(folder / "pulse-shm-1") << "another program's";
  CHECK(check_shared_memory(folder.string()).front().verdict == Verdict::kGood);
  std::ofstream(folder / "fastrtps_1234") << "left behind";
  std::ofstream(folder / "sem.fastrtps_port7411_mutex") << "left behind";
  const Check check = check_shared_memory(folder.string()).front();
  CHECK(check.verdict == Verdict::kNote);
  CHECK_THAT(check.found, Contains("2 DDS files"));
  CHECK_THAT(check.help, Contains("rm "));
}

TEST_CASE("the doctor's summary says the worst, for people and for machines") {
  const Checks fine{{"A", "well", Verdict::kGood, ""}, {"A", "so-so", Verdict::kWarn, "do this"}};
  CHECK_THAT(to_text(fine, false),
             Contains("→ do this") && Contains("Fit to fly; 1 thing could be better."));
  CHECK(to_json(fine)["fit"] == true);
  const Checks ill{{"A", "broken", Verdict::kBad, "do that"}};
  CHECK_THAT(to_text(ill, false), Contains("1 thing is wrong."));
  CHECK(to_json(ill)["fit"] == false);
  CHECK(to_json(ill)["checks"][0]["verdict"] == "bad");
}

TEST_CASE("a robot's file that names no mission is bad input") {
  CHECK_THROWS_AS(check_robot_file("/nonexistent/3.yaml"), BadInput);
}

TEST_CASE("both vendors are loaded, meet each other and talk") {
  for (const Check& check : check_vendors()) CHECK(check.verdict == Verdict::kGood);
  const Checks meetings = check_matching();
  CHECK(meetings.size() == 4);
  for (const Check& check : meetings) {
    CAPTURE(check.found);
    CHECK(check.verdict == Verdict::kGood);
  }
}

TEST_CASE("a robot's file is checked against the mission and this computer") {
  const fs::path folder = fs::temp_directory_path() / "muster_doctor_robot";
  fs::remove_all(folder);
  fs::create_directories(folder / "state");
  const auto check = [&](const std::string& lines) {
    const fs::path path = folder / "3.yaml";
    std::ofstream(path) << "mission: " MUSTER_SOURCE_DIR "/deploy/missions/pagoda.yaml\nstate_dir: "
                        << (folder / "state").string() << "\n"
                        << lines;
    return to_text(check_robot_file(path.string()), false);
  };
  CHECK_THAT(check("id: 1\ninterface: lo\nprofile: wifi-unicast\npeers: [10.42.0.1]\n"),
             Contains("robot 1 of mission pagoda") && Contains("interface lo is up") &&
                 Contains("1 peer") && Contains("Fit to fly"));
  CHECK_THAT(check("id: 99\ninterface: lo\n"),
             Contains("robot 99 is not in the fleet") && Contains("the fleet is "));
  CHECK_THAT(check("id: 1\ninterface: nosuch0\n"), Contains("there is no interface nosuch0"));
  CHECK_THAT(check("id: 1\ninterface: lo\n"),
             Contains("lo has no multicast, and no peers are listed"));
  CHECK_THAT(check("id: 1\ninterface: lo\npeers: [not.a.host.invalid]\n"),
             Contains("not.a.host.invalid is neither an address nor a known name"));
}
