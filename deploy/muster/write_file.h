#pragma once

#include <string>

namespace muster::command {

/// Written aside and renamed, so that nobody ever reads half of it. Throws Failure when that is not
/// possible.
void write_file(const std::string& path, const std::string& content);

}  // namespace muster::command
