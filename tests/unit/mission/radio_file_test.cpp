#include "common/mission/radio_file.h"

#include <catch2/catch.hpp>

#include "common/radio/presets.h"

using namespace muster;
using namespace muster::mission;

namespace {

Mission with_two() {
  Mission m;
  m.fleet.resize(2);
  m.fleet[0].id = RobotId{1};
  m.fleet[1].id = RobotId{2};
  return m;
}

radio::RadioConfig read(const std::string& yaml) {
  Mission m = with_two();
  YamlMap map(YAML::Load(yaml), "m.yaml", "");
  read_radio(map.child("radio"), m);
  return m.radio;
}

std::string complaint(const std::string& yaml) {
  try {
    read(yaml);
  } catch (const BadInput& e) {
    return e.what();
  }
  return "none";
}

}  // namespace

TEST_CASE("without a word about it the radio is the papers'") {
  const auto radio = read("radio: {}");
  CHECK(radio.preset == "paper");
  CHECK(radio.range_m == 5);
  CHECK(radio.line_of_sight);
  CHECK_FALSE(radio.path_loss);
  CHECK_FALSE(radio.mesh);
}

TEST_CASE("a mission changes what it names of a preset") {
  const auto radio =
      read("radio: {preset: wifi-5ghz, wall_loss_db: 7.5, bit_rate_mbps: 24, always_on: [[1, 2]]}");
  REQUIRE(radio.path_loss);
  CHECK(radio.path_loss->wall_loss_db == 7.5);
  CHECK(radio.path_loss->exponent == radio::preset("wifi-5ghz")->path_loss->exponent);
  CHECK(radio.bit_rate_mbps == 24);
  CHECK(radio.always_on.size() == 1);
}

TEST_CASE("a weaker radio is counted on less far, unless the mission says how far") {
  const double usual_m = radio::preset("uwb")->range_m;
  CHECK(read("radio: {preset: uwb, tx_power_dbm: -30}").range_m < usual_m / 2);
  CHECK(read("radio: {preset: uwb, tx_power_dbm: -30, range_m: 9}").range_m == 9);
}

TEST_CASE("a mesh is a preset of its own with hops") {
  const auto radio = read("radio: {loss: 0.1, mesh: {preset: 900mhz, hops: 3, latency_ms: 50}}");
  CHECK(radio.preset == "paper");
  CHECK(radio.loss == 0.1);
  REQUIRE(radio.mesh);
  CHECK(radio.mesh->preset == "900mhz");
  CHECK(radio.mesh->hops == 3);
  CHECK(radio.mesh->channel.latency_ms == 50);
  CHECK(radio.mesh->channel.path_loss);
}

TEST_CASE("what is written down reads back as the same radio") {
  for (const char* yaml :
       {"radio: {}", "radio: {preset: uwb, fade_db: 3.5, always_on: [[2, 1]]}",
        "radio: {range_m: 7, line_of_sight: false, mesh: {preset: 900mhz, hops: 4}}"}) {
    const std::string text = radio_to_yaml(read(yaml));
    CHECK(radio_to_yaml(read(text)) == text);
  }
}

TEST_CASE("a mistake about the radio is one line that says what would be right") {
  CHECK(complaint("radio: {preset: wifi}") ==
        "m.yaml:1: radio.preset: 'wifi' is not one of paper, wifi-5ghz, uwb, 900mhz");
  CHECK(complaint("radio: {wall_loss_db: 3}") ==
        "m.yaml:1: radio.wall_loss_db: the radio 'paper' ends at range_m and has no signal: choose "
        "preset wifi-5ghz, uwb or 900mhz");
  CHECK(complaint("radio:\n  preset: uwb\n  line_of_sight: true") ==
        "m.yaml:3: radio.line_of_sight: the radio 'uwb' passes walls and pays wall_loss_db for "
        "each");
  CHECK(complaint("radio: {loss: 1.5}") == "m.yaml:1: radio.loss: must be between 0 and 1");
  CHECK(complaint("radio: {mesh: {hops: 2}}") == "m.yaml:1: radio.mesh: 'preset' is missing");
  CHECK(complaint("radio: {mesh: {preset: uwb, hops: 0}}") ==
        "m.yaml:1: radio.mesh.hops: must be between 1 and 16");
  CHECK(complaint("radio: {mesh: {preset: uwb, always_on: []}}")
            .starts_with("m.yaml:1: radio.mesh.always_on: unknown key; known here:"));
  CHECK(complaint("radio: {always_on: [[1, 9]]}") ==
        "m.yaml:1: radio.always_on: there is no robot 9");
  CHECK(complaint("radio: {preset: uwb, fade: 2}")
            .starts_with("m.yaml:1: radio.fade: unknown key; known here:"));
}
