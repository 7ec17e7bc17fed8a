#pragma once

#include <optional>
#include <string>
#include <vector>

namespace muster::mission {

/// Where installed missions, vehicles and scenes lie: $MUSTER_DATA, then `../share/muster` beside
/// the program, then /usr/share/muster.
std::vector<std::string> data_dirs();

/// The file that `name`, written in a file of folder `from`, stands for: relative to `from`, in
/// `<from>/../<kind>`, or in
/// `<data dir>/<kind>`; `.yaml` may be left out. Absolute, or nullopt.
std::optional<std::string> find_data(const std::string& name, const std::string& from,
                                     const std::string& kind);

}  // namespace muster::mission
