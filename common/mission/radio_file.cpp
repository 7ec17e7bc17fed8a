#include "common/mission/radio_file.h"

#include <charconv>
#include <sstream>

#include "common/mission/reading.h"
#include "common/radio/path_loss.h"
#include "common/radio/presets.h"

namespace muster::mission {
namespace {

using radio::ChannelConfig;
using radio::PathLossConfig;

struct PathLossKey {
  const char* name;
  double PathLossConfig::*value;
  double low, high;
};
constexpr PathLossKey kPathLossKeys[] = {
    {"tx_power_dbm", &PathLossConfig::tx_power_dbm, -60, 60},
    {"sensitivity_dbm", &PathLossConfig::sensitivity_dbm, -150, 0},
    {"loss_at_1m_db", &PathLossConfig::loss_at_1m_db, 0, 120},
    {"path_loss_exponent", &PathLossConfig::exponent, 1, 8},
    {"shadowing_db", &PathLossConfig::shadowing_db, 0, 20},
    {"shadowing_distance_m", &PathLossConfig::shadowing_distance_m, 0.5, 1000},
    {"asymmetry_db", &PathLossConfig::asymmetry_db, 0, 20},
    {"wall_loss_db", &PathLossConfig::wall_loss_db, 0, 200},
    {"fade_db", &PathLossConfig::fade_db, 0.1, 20},
};

ChannelConfig read_preset(YamlMap& map, std::string& name) {
  map.read("preset", name);
  if (const auto preset = radio::preset(name)) return *preset;
  std::string known;
  for (const std::string& p : radio::preset_names()) known += (known.empty() ? "" : ", ") + p;
  map.fail("preset", "'" + name + "' is not one of " + known);
}

/// What only one of the two kinds of radio has; the other kind's keys are told apart from misspelt
/// ones.
void read_kind(YamlMap& map, const std::string& preset, ChannelConfig& c) {
  if (!c.path_loss) {
    for (const PathLossKey& key : kPathLossKeys) {
      if (map.has(key.name)) {
        map.fail(key.name, "the radio '" + preset +
                               "' ends at range_m and has no signal: choose preset wifi-5ghz, uwb "
                               "or 900mhz");
      }
    }
    map.read("line_of_sight", c.line_of_sight);
    return;
  }
  if (map.has("line_of_sight")) {
    map.fail("line_of_sight",
             "the radio '" + preset + "' passes walls and pays wall_loss_db for each");
  }
  for (const PathLossKey& key : kPathLossKeys) {
    read_between(map, key.name, (*c.path_loss).*key.value, key.low, key.high);
  }
  c.range_m = radio::dependable_range_m(c);
}

void read_channel(YamlMap& map, const std::string& preset, ChannelConfig& c) {
  read_between(map, "loss", c.loss, 0, 1);
  read_kind(map, preset, c);
  read_positive(map, "range_m", c.range_m);
  read_between(map, "bit_rate_mbps", c.bit_rate_mbps, 0, 100'000);
  read_count(map, "frame_bytes", c.frame_bytes, 32, 65'535);
  read_between(map, "frame_overhead_us", c.frame_overhead_us, 0, 1'000'000);
  read_between(map, "queue_ms", c.queue_ms, 0, 60'000);
  read_between(map, "latency_ms", c.latency_ms, 0, 60'000);
}

radio::MeshConfig read_mesh(YamlMap map) {
  radio::MeshConfig mesh;
  map.require("preset", mesh.preset);
  mesh.channel = read_preset(map, mesh.preset);
  read_channel(map, mesh.preset, mesh.channel);
  read_count(map, "hops", mesh.hops, 1, 16);
  map.finish();
  return mesh;
}

void read_always_on(YamlMap& map, Mission& m) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  map.read("always_on", pairs);
  for (const auto& [a, b] : pairs) {
    for (const std::uint32_t id : {a, b}) {
      if (!m.has(RobotId{id})) map.fail("always_on", "there is no robot " + std::to_string(id));
    }
    m.radio.always_on.emplace_back(RobotId{a}, RobotId{b});
  }
}

/// The shortest text that reads back as the same number.
std::string num(double x) {
  char buffer[64];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, x).ptr};
}

std::string channel_to_yaml(const ChannelConfig& c) {
  std::ostringstream out;
  out << ", range_m: " << num(c.range_m) << ", loss: " << num(c.loss)
      << ", bit_rate_mbps: " << num(c.bit_rate_mbps) << ", frame_bytes: " << c.frame_bytes
      << ", frame_overhead_us: " << num(c.frame_overhead_us) << ", queue_ms: " << num(c.queue_ms)
      << ", latency_ms: " << num(c.latency_ms);
  if (!c.path_loss) {
    out << ", line_of_sight: " << (c.line_of_sight ? "true" : "false");
  } else {
    for (const PathLossKey& key : kPathLossKeys) {
      out << ", " << key.name << ": " << num((*c.path_loss).*key.value);
    }
  }
  return out.str();
}

}  // namespace

void read_radio(YamlMap map, Mission& m) {
  static_cast<ChannelConfig&>(m.radio) = read_preset(map, m.radio.preset);
  read_channel(map, m.radio.preset, m.radio);
  read_always_on(map, m);
  if (map.has("mesh")) m.radio.mesh = read_mesh(map.child("mesh"));
  map.child("mesh");  // so that the key counts as known
  map.finish();
}

std::string radio_to_yaml(const radio::RadioConfig& config) {
  std::ostringstream out;
  out << "radio: {preset: " << config.preset << channel_to_yaml(config) << ", always_on: [";
  for (std::size_t k = 0; k < config.always_on.size(); ++k) {
    const auto& [a, b] = config.always_on[k];
    out << (k ? ", " : "") << "[" << a.value << ", " << b.value << "]";
  }
  out << "]";
  if (config.mesh) {
    out << ",\n        mesh: {preset: " << config.mesh->preset << ", hops: " << config.mesh->hops
        << channel_to_yaml(config.mesh->channel) << "}";
  }
  out << "}\n";
  return out.str();
}

}  // namespace muster::mission
