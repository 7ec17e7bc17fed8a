#pragma once

#include <span>
#include <string>

#include "common/robot/knowledge.h"
#include "gcs/contact_log.h"

namespace muster::gcs {

/// Writes what the station holds as a SQLite database that people can read with `sqlite3` (README:
/// its tables). Replaces the file as a whole: a reader never sees half. Throws Failure when it
/// cannot be written.
void write_results(const robot::Knowledge& knowledge, std::span<const Contact> contacts,
                   const std::string& path);

}  // namespace muster::gcs
