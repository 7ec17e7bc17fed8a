#include "deploy/muster/report.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"
#include "tests/text_of.h"
#include "tests/unit/command/fake_run.h"

using namespace muster;
using namespace muster::command;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

fs::path fresh(const std::string& name) {
  const fs::path dir = fs::temp_directory_path() / ("muster_report_" + name);
  fs::remove_all(dir);
  return dir;
}

std::string report_of(const fs::path& dir) {
  write_report(dir.string());
  return test::text_of(dir / "report.html");
}

}  // namespace

TEST_CASE("a report says the result, who was lost, and shows every part of the run") {
  const fs::path dir = fresh("whole");
  write_fake_run(dir.string());
  const std::string page = report_of(dir);
  CHECK_THAT(page, Contains("Complete in 8 min 48 s"));
  CHECK_THAT(page, Contains("One station, one explorer and three inspectors"));
  CHECK_THAT(page, Contains("inspector 4 at 7:10"));
  CHECK_THAT(page, Contains("From above") && Contains("data:image/png;base64,"));
  CHECK_THAT(page, Contains("delivered <b>60</b>"));
  CHECK_THAT(page, Contains("hears station 0 2:00–2:12"));
  CHECK_THAT(page, Contains("Planning, in milliseconds"));
  CHECK_FALSE(fs::exists(dir / "report.html.new"));
}

TEST_CASE("a report needs no network") {
  const fs::path dir = fresh("offline");
  write_fake_run(dir.string());
  const std::string page = report_of(dir);
  CHECK_THAT(page, !Contains("http:") && !Contains("https:") && !Contains("<link") &&
                       !Contains("@import"));
}

TEST_CASE("whatever is missing from a run, the rest of the report is there") {
  for (const std::string gone :
       {"summary.json", "events.jsonl", "tracks.csv", "features.csv", "map.bt"}) {
    CAPTURE(gone);
    const fs::path dir = fresh("partial");
    write_fake_run(dir.string(), 60);
    fs::remove(dir / gone);
    const std::string page = report_of(dir);
    CHECK_THAT(page, Contains(gone + " is missing"));
    CHECK_THAT(page, Contains("</html>"));
  }
}

TEST_CASE("damaged files are named, not fatal") {
  const fs::path dir = fresh("damaged");
  fs::create_directories(dir);
  std::ofstream(dir / "summary.json") << "{\"complete\": tr";
  std::ofstream(dir / "events.jsonl")
      << "{\"t_s\": 1, \"event\": 7}\nnot json\n{\"t_s\": \"soon\"}\n";
  std::ofstream(dir / "tracks.csv")
      << "t_s,robot,x,y,z,yaw_rad,activity\n1,1,nan,2,3,0,exploring\n2,x,1,2,3,0,idle\n3,1,1,2\n";
  std::ofstream(dir / "features.csv") << "id,type,x\n1,0,2\n";
  std::ofstream(dir / "map.bt") << "not a map";
  const std::string page = report_of(dir);
  CHECK_THAT(page, Contains("summary.json is damaged") &&
                       Contains("2 lines of events.jsonl are damaged") &&
                       Contains("map.bt is damaged"));
}

TEST_CASE("text from a run cannot become markup") {
  const fs::path dir = fresh("markup");
  fs::create_directories(dir);
  std::ofstream(dir / "summary.json")
      << R"({"mission": "<script>alert(1)</script>", "complete": false, "ended": "<b>"})";
  std::ofstream(dir / "tracks.csv")
      << "t_s,robot,x,y,z,yaw_rad,activity\n1,1,0,0,0,0,\"><img src=x>\n";
  const std::string page = report_of(dir);
  CHECK_THAT(page, !Contains("<script>alert") && !Contains("<img src=x>") && Contains("&lt;b&gt;"));
}

TEST_CASE("a directory without a run is bad input") {
  CHECK_THROWS_AS(write_report("/nonexistent/run"), BadInput);
  const fs::path dir = fresh("empty");
  fs::create_directories(dir);
  CHECK_THROWS_AS(write_report(dir.string()), BadInput);
}
