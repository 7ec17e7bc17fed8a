#pragma once

#include <string>

#include "common/robot/knowledge.h"

namespace muster::gcs {

/// Writes what the station holds as a SQLite database that people can read with `sqlite3`: tables
/// `areas`, `inspections`, `findings`, `images`, `regions`, `robots`, and the view `features` (one
/// row per feature found). Replaces the file as a whole: a reader never sees half. Throws Failure
/// when it cannot be written.
void write_results(const robot::Knowledge& knowledge, const std::string& path);

}  // namespace muster::gcs
