#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/core/error.h"

namespace muster {

/// Reads one YAML mapping key by key and complains in one line: `file:line: key: what is wrong`. A
/// key nobody asked for is an error when `finish()` is called, so that a misspelt one never passes
/// in silence.
///
///     YamlMap map = YamlMap::load(path);
///     map.read("range_m", config.range_m);            // optional: keeps the default
///     map.require("scene", mission.scene);            // must be there
///     for (YamlMap item : map.list("fleet")) …
///     map.finish();
class YamlMap {
 public:
  /// Throws BadInput when the file is missing, not YAML, or not a mapping.
  static YamlMap load(const std::string& path);
  YamlMap(const YAML::Node& node, std::string file, std::string path);

  bool has(const std::string& key) const { return bool(node_[key]); }

  template <class T>
  void read(const std::string& key, T& value) {
    seen_.insert(key);
    if (const YAML::Node n = node_[key]) convert(n, key, value);
  }
  template <class T>
  void read(const std::string& key, std::optional<T>& value) {
    seen_.insert(key);
    if (const YAML::Node n = node_[key]) convert(n, key, value.emplace());
  }
  template <class T>
  void require(const std::string& key, T& value) {
    if (!has(key)) fail("", "'" + key + "' is missing");
    read(key, value);
  }
  /// The mapping under `key`; empty when absent.
  YamlMap child(const std::string& key);
  /// The mappings in the sequence under `key`; empty when absent.
  std::vector<YamlMap> list(const std::string& key);
  /// Throws BadInput for the first key that was never read.
  void finish() const;

  /// `file:line: key`, for complaints that can only be made later.
  std::string place(const std::string& key) const;
  /// Throws BadInput: `file:line: key: message`. With `key` empty, the line of the mapping itself.
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;

  int line() const { return node_.Mark().line + 1; }
  const std::string& file() const { return file_; }

 private:
  template <class T>
  void convert(const YAML::Node& n, const std::string& key, T& value) {
    try {
      value = n.as<T>();
    } catch (const YAML::Exception&) {
      fail(key, "'" + text(n) + "' is not " + expected<T>());
    }
  }
  void convert(const YAML::Node& n, const std::string& key, Eigen::Vector3d& value);
  void convert(const YAML::Node& n, const std::string& key, double& value);

  template <class T>
  static std::string expected() {
    if constexpr (std::is_same_v<T, bool>)
      return "true or false";
    else if constexpr (std::is_arithmetic_v<T>)
      return "a number that fits here";
    else if constexpr (std::is_same_v<T, std::string>)
      return "a text";
    else
      return "of the right form";
  }
  static std::string text(const YAML::Node& n);

  YAML::Node node_;
  std::string file_;
  std::string path_;
  std::set<std::string> seen_;
};

}  // namespace muster
