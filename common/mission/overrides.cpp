#include "common/mission/overrides.h"

#include <charconv>

#include "common/core/error.h"

namespace muster::mission {
namespace {

YAML::Node with_value(const YAML::Node& node, const std::string& path, const YAML::Node& value,
                      const std::string& assignment) {
  if (path.empty()) return value;
  const std::size_t dot = path.find('.');
  const std::string key = path.substr(0, dot);
  const std::string rest = dot == std::string::npos ? "" : path.substr(dot + 1);
  if (key.empty()) throw BadInput("--set " + assignment + ": the key has an empty part");
  YAML::Node result = YAML::Clone(node);
  if (node.IsSequence()) {
    std::size_t i = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), i);
    if (error != std::errc{} || end != key.data() + key.size() || i >= node.size()) {
      throw BadInput("--set " + assignment + ": '" + key + "' is no index of a list of " +
                     std::to_string(node.size()));
    }
    result[i] = with_value(node[i], rest, value, assignment);
  } else if (node.IsMap() || node.IsNull()) {
    const YAML::Node inner = node.IsMap() && node[key] ? node[key] : YAML::Node();
    result[key] = with_value(inner, rest, value, assignment);
  } else {
    throw BadInput("--set " + assignment + ": '" + key + "' would be inside a single value");
  }
  return result;
}

}  // namespace

void apply_override(YAML::Node& root, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw BadInput("--set " + assignment + ": 'key=value' is expected");
  }
  YAML::Node value;
  try {
    value = YAML::Load(assignment.substr(equals + 1));
  } catch (const YAML::Exception& e) {
    throw BadInput("--set " + assignment + ": the value is not YAML: " + e.msg);
  }
  root = with_value(root, assignment.substr(0, equals), value, assignment);
}

std::string without_place(const std::string& message, const std::string& file) {
  if (!message.starts_with(file + ":")) return message;
  const std::size_t colon = message.find(": ", file.size() + 1);
  return colon == std::string::npos ? message : message.substr(colon + 2);
}

}  // namespace muster::mission
