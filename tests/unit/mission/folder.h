#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/mission/mission.h"

namespace muster::mission::testing {

inline const std::string kGood =
    "scene: place.yaml\n"                               // 1
    "hull: {low: [-10, -10, 0], high: [10, 10, 10]}\n"  // 2
    "boxes:\n"                                          // 3
    "  - {low: [-5, -5, 0.3], high: [5, 5, 8]}\n"       // 4
    "fleet:\n"                                          // 5
    "  - {role: station, vehicle: cart, first_id: 1, starts: [[0, 7, 0.4]]}\n"
    "  - {role: explorer, vehicle: quad, first_id: 2, starts: [[0, 8.5, 1, 90]]}\n"
    "  - {role: inspector, vehicle: quad, first_id: 3, starts: [[-2, 8, 1], [2, 8, 1]]}\n"
    "standing: {place: [0, 8, 1], t0_s: 100}\n"  // 9
    "seed: 4\n";                                 // 10

/// A folder with a mission, its scene and its vehicles.
class Folder {
 public:
  Folder() {
    std::filesystem::create_directories(dir_);
    write("place.yaml", "parts: []\n");
    write("cart.yaml", "ground: true\nradius_m: 0.3\n");
    write("quad.yaml", "radius_m: 0.25\ncamera: {hfov_deg: 80, vfov_deg: 47.3}\n");
  }
  ~Folder() { std::filesystem::remove_all(dir_); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(dir_ / name) << text;
  }
  Mission load(const std::string& text, const std::vector<std::string>& set = {}) const {
    write("m.yaml", text);
    return Mission::load(path(), set);
  }
  std::string path() const { return (dir_ / "m.yaml").string(); }
  /// With `faults` beside it in a file of its own.
  Mission load_with(const std::string& text, const std::string& faults) const {
    write("m.yaml", text);
    write("f.yaml", faults);
    return Mission::load(path(), {}, (dir_ / "f.yaml").string());
  }
  /// The complaint about `text`, without the folder.
  std::string complaint(const std::string& text, const std::vector<std::string>& set = {}) const {
    return complaint_of([&] { load(text, set); });
  }
  std::string complaint_with(const std::string& text, const std::string& faults) const {
    return complaint_of([&] { load_with(text, faults); });
  }

 private:
  template <class Read>
  std::string complaint_of(const Read& read) const {
    try {
      read();
      return "none";
    } catch (const BadInput& e) {
      std::string what = e.what();
      const std::string folder = dir_.string() + "/";
      for (auto at = what.find(folder); at != std::string::npos; at = what.find(folder)) {
        what.erase(at, folder.size());
      }
      return what;
    }
  }

  std::filesystem::path dir_ =
      std::filesystem::temp_directory_path() / ("muster_mission_test_" + std::to_string(getpid()));
};

}  // namespace muster::mission::testing
