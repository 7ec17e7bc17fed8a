#include "common/radio/presets.h"

#include "common/radio/path_loss.h"

namespace muster::radio {
namespace {

ChannelConfig wifi_5ghz() {
  ChannelConfig c;
  c.path_loss = PathLossConfig{.tx_power_dbm = 15,
                               .sensitivity_dbm = -82,
                               .loss_at_1m_db = 47.2,
                               .exponent = 2.1,
                               .shadowing_db = 4,
                               .shadowing_distance_m = 10,
                               .asymmetry_db = 2,
                               .wall_loss_db = 20,
                               .fade_db = 2};
  c.bit_rate_mbps = 6;
  c.frame_bytes = 1400;
  c.frame_overhead_us = 200;
  c.latency_ms = 2;
  return c;
}

ChannelConfig uwb() {
  ChannelConfig c;
  c.path_loss = PathLossConfig{.tx_power_dbm = -14.3,
                               .sensitivity_dbm = -93,
                               .loss_at_1m_db = 45.6,
                               .exponent = 1.76,
                               .shadowing_db = 0.83,
                               .shadowing_distance_m = 10,
                               .asymmetry_db = 1,
                               .wall_loss_db = 23,
                               .fade_db = 2};
  c.bit_rate_mbps = 6.8;
  c.frame_bytes = 1000;
  c.frame_overhead_us = 180;
  c.latency_ms = 1;
  return c;
}

ChannelConfig ism_900mhz() {
  ChannelConfig c;
  c.path_loss = PathLossConfig{.tx_power_dbm = 17,
                               .sensitivity_dbm = -100,
                               .loss_at_1m_db = 31.5,
                               .exponent = 2.1,
                               .shadowing_db = 4,
                               .shadowing_distance_m = 10,
                               .asymmetry_db = 2,
                               .wall_loss_db = 6,
                               .fade_db = 2};
  c.bit_rate_mbps = 0.156;
  c.frame_bytes = 256;
  c.frame_overhead_us = 2000;
  c.latency_ms = 15;
  return c;
}

}  // namespace

const std::vector<std::string>& preset_names() {
  static const std::vector<std::string> names{"paper", "wifi-5ghz", "uwb", "900mhz"};
  return names;
}

std::optional<ChannelConfig> preset(std::string_view name) {
  if (name == "paper") return ChannelConfig{};
  ChannelConfig c;
  if (name == "wifi-5ghz") {
    c = wifi_5ghz();
  } else if (name == "uwb") {
    c = uwb();
  } else if (name == "900mhz") {
    c = ism_900mhz();
  } else {
    return std::nullopt;
  }
  c.range_m = dependable_range_m(c);
  return c;
}

}  // namespace muster::radio
