#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

namespace muster::mission {

/// Applies `a.b=value` to a document: mappings on the way are made when missing, a number indexes a
/// list that exists
/// (`fleet.0.vehicle=…`). Throws BadInput for anything else.
void apply_override(YAML::Node& root, const std::string& assignment);

/// `message` without a leading `file:line: `.
std::string without_place(const std::string& message, const std::string& file);

}  // namespace muster::mission
