#include "deploy/muster/progress.h"

#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <sstream>
#include <vector>

#include "tests/text_of.h"

using namespace muster::command;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// What `speak` writes to stdout.
std::string heard(const std::function<void()>& speak) {
  const fs::path path = fs::temp_directory_path() / ("muster_progress_" + std::to_string(getpid()));
  std::fflush(stdout);
  const int stdout_before = dup(STDOUT_FILENO);
  std::FILE* file = std::fopen(path.c_str(), "w");
  REQUIRE(file != nullptr);
  dup2(fileno(file), STDOUT_FILENO);
  speak();
  std::fflush(stdout);
  dup2(stdout_before, STDOUT_FILENO);
  close(stdout_before);
  std::fclose(file);
  std::string text = muster::test::text_of(path);
  fs::remove(path);
  return text;
}

json state(double t_s) {
  return {{"t_s", t_s},
          {"map_coverage", 0.5},
          {"features_found", 12},
          {"features_total", 150},
          {"robots", {{"1", "waiting"}, {"2", "exploring"}, {"3", "waiting"}}}};
}

std::ptrdiff_t lines_in(const std::string& text) {
  return std::count(text.begin(), text.end(), '\n');
}

}  // namespace

TEST_CASE("when piped, progress is a plain line every ten simulated seconds") {
  const std::string text = heard([] {
    Progress progress(Progress::Form::kPlain);
    for (int t_s = 0; t_s < 30; ++t_s) progress.show(state(t_s));
    progress.note("robot 3 is lost");
  });
  CHECK(lines_in(text) == 4);
  CHECK(text.find("map  50.0 %  found 12/150") != std::string::npos);
  CHECK(text.find("1 exploring, 2 waiting") != std::string::npos);
  CHECK(text.ends_with("robot 3 is lost\n"));
  CHECK(text.find('\r') == std::string::npos);
}

TEST_CASE("for machines, every line is one JSON object") {
  const std::string text = heard([] {
    Progress progress(Progress::Form::kJson);
    progress.show(state(0));
    progress.show(state(1));
    progress.note("robot 3 is lost");
    progress.result({{"complete", true}}, "runs/x");
  });
  std::istringstream lines(text);
  std::vector<json> objects;
  for (std::string line; std::getline(lines, line);) objects.push_back(json::parse(line));
  REQUIRE(objects.size() == 4);
  CHECK(objects[1]["t_s"] == 1.0);
  CHECK(objects[1].contains("real_time_factor"));
  CHECK(objects[2]["note"] == "robot 3 is lost");
  CHECK(objects[3]["summary"]["complete"] == true);
}

TEST_CASE("on a terminal the line is drawn over, and ended before anything else is said") {
  const std::string text = heard([] {
    Progress progress(Progress::Form::kTerminal);
    progress.show(state(0));
    progress.show(state(1));  // too soon to be seen
    progress.note("robot 3 is lost");
  });
  CHECK(text.starts_with("\r\x1b[2K"));
  CHECK(lines_in(text) == 2);
  CHECK(text.ends_with("\nrobot 3 is lost\n"));
}

TEST_CASE("robots are counted by what they do") {
  CHECK(count_activities({{"1", "waiting"}, {"2", "exploring"}, {"3", "waiting"}}) ==
        "1 exploring, 2 waiting");
  CHECK(count_activities(json::object()).empty());
}
