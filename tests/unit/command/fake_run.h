#pragma once

#include <string>

namespace muster::command {

/// Writes a directory as a run would leave it: a small pagoda in map.bt, five robots that fly
/// around it for `end_s` seconds, sixty features, contacts and a summary. One inspector is lost on
/// the way. Everything is made up by formulas, nothing is drawn at random.
void write_fake_run(const std::string& dir, double end_s = 600);

}  // namespace muster::command
