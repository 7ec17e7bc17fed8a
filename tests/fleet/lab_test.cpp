// `muster lab` with real processes: a log of poses is played, three robots (lab_peer) say beacons.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "tests/free_domain.h"
#include "tests/programs.h"

namespace fs = std::filesystem;
using namespace muster::test;

namespace {

const std::string kBin = MUSTER_BIN_DIR;
const std::string kMissions = std::string(MUSTER_SOURCE_DIR) + "/tests/missions/";

/// A program in the background, what it says in a file; ended with the object.
class Background {
 public:
  Background(const std::string& line, std::string says)
      : says_(std::move(says)), pid_(start(fmt::format("{} > {}", line, says_))) {}
  ~Background() {
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  std::string said() const { return text_of(says_); }
  void await(const std::string& word) const {
    for (int i = 0; i < 1200 && said().find(word) == std::string::npos; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    REQUIRE(said().find(word) != std::string::npos);
  }
  /// By whose beacons.
  std::set<int> heard() const {
    std::set<int> all;
    std::istringstream text(said());
    for (std::string line; std::getline(text, line);) {
      if (line.starts_with("heard ")) all.insert(std::stoi(line.substr(6)));
    }
    return all;
  }

 private:
  std::string says_;
  pid_t pid_;
};

Ended lab(const std::string& arguments) {
  return shell("timeout 120 " + kBin + "/muster lab " + arguments);
}

using Row = std::map<std::string, double>;

std::vector<Row> read_csv(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> names;
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    std::string cell;
    if (names.empty()) {
      while (std::getline(cells, cell, ',')) names.push_back(cell);
      continue;
    }
    Row row;
    for (const std::string& name : names) {
      std::getline(cells, cell, ',');
      row[name] = std::stod(cell);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Sums over what two robots said to each other.
Row between(const std::vector<Row>& air, int a, int b) {
  Row sum;
  for (const Row& row : air) {
    const bool theirs =
        (row.at("from") == a && row.at("to") == b) || (row.at("from") == b && row.at("to") == a);
    if (!theirs) continue;
    for (const auto& [name, value] : row) sum[name] += value;
  }
  return sum;
}

/// Of two robots, in the last row of each until then.
double distance_m(const std::vector<Row>& tracks, int a, int b, double t_s) {
  std::map<double, Row> last;
  for (const Row& row : tracks) {
    if (row.at("t_s") <= t_s) last[row.at("robot")] = row;
  }
  return std::abs(last.at(a).at("x") - last.at(b).at("x"));
}

int count(const std::string& text, const std::string& word) {
  int n = 0;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_CASE(
    "in a lab who comes near is heard, who is behind a wall is not, and who is out of sight falls "
    "silent") {
  const std::string vendor = GENERATE("cyclonedds", "fastdds");
  INFO(vendor);
  const Place place;
  const std::string domain = std::to_string(free_domain());
  const std::string peer = kBin + "/lab_peer ", at = " " + vendor + " " + domain + " ";
  const Background drivers(peer + "drivers" + at + "1 2 3", place / "drivers");
  drivers.await("up");
  const Background one(peer + "robot" + at + "1", place / "one"),
      two(peer + "robot" + at + "2", place / "two"),
      three(peer + "robot" + at + "3", place / "three");
  const Ended ended =
      lab(fmt::format("{0}lab.yaml --poses {0}lab_poses.csv --await 1,2,3 --domain {1} --dds {2} "
                      "--out {3}",
                      kMissions, domain, vendor, place / "out"));
  INFO(ended.output);
  REQUIRE(ended.status == 0);
  CHECK(one.heard() == std::set{2});
  CHECK(two.heard() == std::set{1});
  CHECK(three.heard().empty());

  const auto air = read_csv(place / "out/air.csv"), tracks = read_csv(place / "out/tracks.csv");
  const Row friends = between(air, 1, 2), neighbours = between(air, 1, 3);
  CHECK(friends.at("range") > 0);
  CHECK(friends.at("heard") > 0);
  CHECK(friends.at("wall") == 0);
  CHECK(friends.at("pose") > 0);
  CHECK(neighbours.at("wall") > 0);
  CHECK(neighbours.at("heard") == 0);

  const auto summary = summary_of(place / "out");
  REQUIRE(summary["contacts"].size() == 1);
  const double met_s = summary["contacts"][0]["intervals"][0][0];
  CHECK(distance_m(tracks, 1, 2, met_s) < 8);
  CHECK(distance_m(tracks, 1, 2, summary["contacts"][0]["intervals"].back()[1]) == 2);
  const auto seen = ended.output.find("robot 2 is seen");
  REQUIRE(seen != std::string::npos);
  CHECK(count(ended.output.substr(seen), "robot 2 is not seen") == 1);
}

TEST_CASE("a lab says in one line what it cannot play") {
  const Place place;
  std::ofstream(place / "bad.csv") << "t_s,robot,x,y,z\n0,1,0,0,1\n1,1,0,zero,1\n";
  const std::vector<std::pair<std::string, std::string>> table{
      {"lab.yaml --poses " + place / "bad.csv", "bad.csv:3: y: 'zero' is not a number"},
      {"lab.yaml --poses nowhere.csv", "nowhere.csv: there is no such file"},
      {"lab.yaml --await 1", "--await: needs a log"},
      {"lab.yaml --domain 99", "--domain: must be below 99"},
      {"lab.yaml --transport-profile pigeon", "profile 'pigeon'"},
      {"lab.yaml --set scene=nowhere.yaml", "nowhere.yaml"},
      {"nowhere.yaml", "nowhere.yaml"},
  };
  for (const auto& [arguments, words] : table) {
    const Ended ended = lab(kMissions + arguments + " --out " + place / "out");
    INFO(ended.output);
    CHECK(ended.status == 2);
    CHECK(count(ended.output, "\n") == 1);
    CHECK(ended.output.find(words) != std::string::npos);
    CHECK_FALSE(fs::exists(place / "out"));
  }
}
