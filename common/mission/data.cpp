#include "common/mission/data.h"

#include <cstdlib>
#include <filesystem>

namespace fs = std::filesystem;

namespace muster::mission {

std::vector<std::string> data_dirs() {
  std::vector<std::string> dirs;
  if (const char* env = std::getenv("MUSTER_DATA"); env && *env) dirs.emplace_back(env);
  std::error_code error;
  if (const fs::path program = fs::read_symlink("/proc/self/exe", error); !error) {
    dirs.push_back((program.parent_path().parent_path() / "share/muster").string());
  }
  dirs.emplace_back("/usr/share/muster");
  return dirs;
}

std::optional<std::string> find_data(const std::string& name, const std::string& from,
                                     const std::string& kind) {
  if (name.empty()) return std::nullopt;
  std::vector<fs::path> places;
  if (fs::path(name).is_absolute()) {
    places = {fs::path()};
  } else {
    places = {fs::path(from), fs::path(from) / ".." / kind};
    for (const std::string& dir : data_dirs()) places.push_back(fs::path(dir) / kind);
  }
  for (const fs::path& place : places) {
    for (const char* extension : {"", ".yaml"}) {
      const fs::path file = place / (name + extension);
      std::error_code error;
      if (fs::is_regular_file(file, error)) return fs::absolute(file).lexically_normal().string();
    }
  }
  return std::nullopt;
}

}  // namespace muster::mission
