#include "common/core/yaml.h"

#include <cmath>
#include <filesystem>
#include <sstream>

namespace muster {

YamlMap YamlMap::load(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw BadInput(path + ": is a directory; a YAML file is expected");
  try {
    return YamlMap(YAML::LoadFile(path), path, "");
  } catch (const YAML::BadFile&) {
    throw BadInput(path + ": cannot be read");
  } catch (const YAML::ParserException& e) {
    throw BadInput(path + ":" + std::to_string(e.mark.line + 1) + ": not YAML: " + e.msg);
  }
}

YamlMap::YamlMap(const YAML::Node& node, std::string file, std::string path)
    : node_(node), file_(std::move(file)), path_(std::move(path)) {
  if (!node_.IsMap() && !node_.IsNull()) fail("", "a mapping 'key: value' is expected here");
}

YamlMap YamlMap::child(const std::string& key) {
  seen_.insert(key);
  const YAML::Node n = node_[key];
  return YamlMap(n ? n : YAML::Node(YAML::NodeType::Map), file_, path_ + key + ".");
}

std::vector<YamlMap> YamlMap::list(const std::string& key) {
  seen_.insert(key);
  std::vector<YamlMap> items;
  const YAML::Node n = node_[key];
  if (!n) return items;
  if (!n.IsSequence()) fail(key, "a list is expected");
  for (std::size_t i = 0; i < n.size(); ++i) {
    items.emplace_back(n[i], file_, path_ + key + "[" + std::to_string(i) + "].");
  }
  return items;
}

void YamlMap::finish() const {
  for (const auto& entry : node_) {
    if (!entry.first.IsScalar()) {
      const std::string group = path_.empty() ? "" : path_.substr(0, path_.size() - 1) + ": ";
      throw BadInput(file_ + ":" + std::to_string(entry.first.Mark().line + 1) + ": " + group +
                     "a key is one word, neither a list nor a mapping");
    }
    const auto key = entry.first.as<std::string>();
    if (seen_.contains(key)) continue;
    std::string known;
    for (const auto& k : seen_) known += (known.empty() ? "" : ", ") + k;
    throw BadInput(file_ + ":" + std::to_string(entry.first.Mark().line + 1) + ": " + path_ + key +
                   ": unknown key; known here: " + known);
  }
}

std::string YamlMap::place(const std::string& key) const {
  int at = node_.Mark().line;
  if (!key.empty() && node_.IsMap() && node_[key]) at = node_[key].Mark().line;
  std::string name = path_ + key;
  if (!name.empty() && name.back() == '.') name.pop_back();
  return file_ + ":" + std::to_string(at + 1) + (name.empty() ? "" : ": " + name);
}

void YamlMap::fail(const std::string& key, const std::string& message) const {
  throw BadInput(place(key) + ": " + message);
}

void YamlMap::convert(const YAML::Node& n, const std::string& key, double& value) {
  try {
    value = n.as<double>();
  } catch (const YAML::Exception&) {
    fail(key, "'" + text(n) + "' is not a number");
  }
  if (!std::isfinite(value)) fail(key, "must be finite");
}

void YamlMap::convert(const YAML::Node& n, const std::string& key, Eigen::Vector3d& value) {
  if (!n.IsSequence() || n.size() != 3) fail(key, "three numbers [x, y, z] are expected");
  for (std::size_t i = 0; i < 3; ++i) convert(n[i], key, value[static_cast<Eigen::Index>(i)]);
}

std::string YamlMap::text(const YAML::Node& n) {
  std::ostringstream out;
  out << n;
  return out.str();
}

}  // namespace muster
