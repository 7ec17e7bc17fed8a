#pragma once

#include <string>

#include "common/core/yaml.h"
#include "common/mission/mission.h"

/// The mission key `radio`: a preset, and what the mission changes about it.
///
///     radio: {preset: wifi-5ghz, wall_loss_db: 12, mesh: {preset: 900mhz, hops: 3}}
namespace muster::mission {

/// Fills `m.radio`; the fleet is known by then. Throws BadInput with file, line and key.
void read_radio(YamlMap map, Mission& m);
/// The same as one line of YAML, every key of it.
std::string radio_to_yaml(const radio::RadioConfig& config);

}  // namespace muster::mission
