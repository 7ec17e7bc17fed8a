#pragma once

#include <numbers>
#include <string>

#include "common/core/yaml.h"

/// Checked readers of single keys: each keeps the default when the key is absent and throws
/// BadInput with file, line and key when the value does not fit.
namespace muster::mission {

inline std::string number_text(double x) {
  std::string s = std::to_string(x);
  s.erase(s.find_last_not_of('0') + 1);
  if (s.back() == '.') s.pop_back();
  return s;
}

inline void read_between(YamlMap& map, const std::string& key, double& value, double low,
                         double high) {
  double v = value;
  map.read(key, v);
  if (v < low || v > high) {
    map.fail(key, "must be between " + number_text(low) + " and " + number_text(high));
  }
  value = v;
}

inline void read_at_least(YamlMap& map, const std::string& key, double& value, double low) {
  double v = value;
  map.read(key, v);
  if (v < low) map.fail(key, "must be at least " + number_text(low));
  value = v;
}

inline void read_positive(YamlMap& map, const std::string& key, double& value) {
  double v = value;
  map.read(key, v);
  if (v <= 0) map.fail(key, "must be greater than 0");
  value = v;
}

/// Degrees in the file, radians in `value_rad`.
inline void read_degrees(YamlMap& map, const std::string& key, double& value_rad, double low_deg,
                         double high_deg) {
  if (!map.has(key)) {
    double unused = 0;
    map.read(key, unused);  // so that the key counts as known
    return;
  }
  double degrees = 0;
  read_between(map, key, degrees, low_deg, high_deg);
  value_rad = degrees * std::numbers::pi / 180;
}

inline void read_count(YamlMap& map, const std::string& key, std::uint32_t& value,
                       std::uint32_t low, std::uint32_t high) {
  std::uint32_t v = value;
  map.read(key, v);
  if (v < low || v > high) {
    map.fail(key, "must be between " + std::to_string(low) + " and " + std::to_string(high));
  }
  value = v;
}

}  // namespace muster::mission
