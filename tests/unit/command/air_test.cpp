#include "deploy/muster/air.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "common/core/error.h"
#include "tests/unit/command/fake_run.h"

using namespace muster;
using namespace muster::command;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

/// A fake run whose station 0 and explorer 1 met every 150 s (fake_run.cpp), and what they said.
fs::path a_run(const std::string& name) {
  const fs::path dir = fs::temp_directory_path() / ("muster_air_" + name);
  fs::remove_all(dir);
  write_fake_run(dir.string());
  std::ofstream(dir / "air.csv")
      << "t_s,from,to,heard,heard_bytes,dropped_bytes,range,wall,dead,scripted,loss,airtime\n"
         "120,0,1,9,4000,0,0,0,0,0,0,0\n"
         "120,1,0,30,250000,900,0,0,0,0,2,1\n"
         "122,1,0,1,100,0,0,0,0,0,0,0\n"
         "598,1,0,0,0,70000,3200,40,0,0,0,0\n"
         "598,0,4,0,0,70000,100,0,7,0,0,0\n"
         "599,0,4,0,0,7";  // cut short in the middle of a row
  return dir;
}

const AirData::Pair& pair_of(const AirData& air, std::uint32_t a, std::uint32_t b) {
  for (const AirData::Pair& pair : air.pairs) {
    if (pair.a == a && pair.b == b) return pair;
  }
  FAIL("no such pair");
  return air.pairs.front();
}

}  // namespace

TEST_CASE("the record of the air adds up by pair, way and reason") {
  const AirData air = read_air(a_run("sums").string());
  const AirData::Pair& pair = pair_of(air, 0, 1);
  CHECK(pair.from_a.messages == 9);
  CHECK(pair.from_b.bytes == 250'100);
  CHECK(pair.from_b.moments.size() == 2);
  CHECK(pair.from_b.moments[0].lost == 3);
  CHECK(pair.from_b.dropped == std::map<std::string, std::uint64_t>{
                                   {"airtime", 1}, {"loss", 2}, {"range", 3200}, {"wall", 40}});
  CHECK(pair.contacts.size() == 4);
  CHECK(pair.together_s == Approx(48));
  CHECK(pair.longest_apart_s == Approx(138));
  CHECK_FALSE(pair_of(air, 0, 4).ever());
  CHECK(air.dropped().at("range") == 3300);
  CHECK(air.dropped().at("dead") == 7);
}

TEST_CASE("the table says who heard whom, who never did, and why not") {
  const std::string table = air_table(read_air(a_run("table").string()));
  CHECK_THAT(table, Contains("station 0, explorer 1") && Contains("0:48") && Contains("2:18"));
  CHECK_THAT(table, Contains("airtime 1, loss 2, range 3200, wall 40"));
  CHECK_THAT(table, Contains("never heard each other: 0–4"));
}

TEST_CASE("meetings are told with their bytes, and the map against whole maps") {
  const fs::path dir = a_run("meetings");
  auto summary = nlohmann::json::parse(std::ifstream(dir / "summary.json"));
  for (auto& pair : summary["contacts"]) {
    pair["meetings"] = 4;
    pair["bytes"] = 8'000'000;
    pair["map_bytes"] = 100'000;
    pair["seconds"] = 40.0;
    pair["data_seconds"] = 10.0;
  }
  const auto pairs = summary["contacts"].size();
  summary["air"]["by_topic"]["map_block"] = {{"bytes", 50'000}, {"messages", 200}};
  std::ofstream(dir / "summary.json") << summary;
  CHECK_THAT(air_table(read_air(dir.string())), !Contains("all of theirs"));
  summary["air"]["whole_map_bytes"] = 600'000;
  summary["air"]["whole_octree_bytes"] = 1'200'000;
  std::ofstream(dir / "summary.json") << summary;
  const AirData air = read_air(dir.string());
  CHECK_THAT(air_table(air), Contains("2000 kB heard in each, 25 kB of it map") &&
                                 Contains("50 kB sent") && Contains("(.bt) 1200 kB, 24.0 times") &&
                                 Contains("own blocks 600 kB, 12.0 times") &&
                                 Contains("for 25 % of the contact"));
  CHECK(air_json(air)["meetings"]["count"] == 4 * pairs);
}

TEST_CASE("the page shows contacts and bytes, and needs no network") {
  const std::string page = air_page(read_air(a_run("page").string()));
  CHECK_THAT(page, Contains("in contact 2:00–2:12") && Contains("class=\"way-b\"") &&
                       Contains("class=\"lost-here\""));
  CHECK_THAT(page, !Contains("http:") && !Contains("https:") && !Contains("<link"));
}

TEST_CASE("for machines there is all of it") {
  const auto json = air_json(read_air(a_run("json").string()));
  CHECK(json["dropped"]["range"] == 3300);
  CHECK(json["pairs"][0]["robots"] == nlohmann::json({0, 1}));
  CHECK(json["pairs"][0]["ways"][1]["moments"][0] == nlohmann::json({120.0, 250000, 3}));
}

TEST_CASE("a run without a simulated radio has no record of its air") {
  const fs::path dir = a_run("direct");
  fs::remove(dir / "air.csv");
  CHECK_THROWS_WITH(read_air(dir.string()), Contains("--link direct"));
  CHECK_THROWS_AS(read_air("/nowhere"), BadInput);
}
