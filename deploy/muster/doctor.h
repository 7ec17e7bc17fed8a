#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace muster::command {

/// One thing that was looked at.
///
///   | verdict | means                                                      |
///   |---------|------------------------------------------------------------|
///   | kGood   | as it should be                                            |
///   | kNote   | worth knowing, changes nothing                             |
///   | kWarn   | works, but slower or only sometimes; `help` says what to do |
///   | kBad    | a mission will fail on this; `help` says what to do         |
struct Check {
  enum class Verdict { kGood, kNote, kWarn, kBad };
  std::string topic;  ///< "network", "DDS", …: checks are shown grouped by it
  std::string found;  ///< one line
  Verdict verdict = Verdict::kGood;
  std::string help;  ///< what would help; may hold a command to paste
};
using Checks = std::vector<Check>;
const char* to_string(Check::Verdict verdict);

// This computer. Each looks and changes nothing.
Checks check_interfaces();
Checks check_ports();
Checks check_buffers();
Checks check_shared_memory(const std::string& folder = "/dev/shm");
Checks check_processes();
Checks check_clock();

/// Versions of both vendors, as loaded into this process.
Checks check_vendors();
/// Opens a participant of each vendor as hub and as agent on a free domain, all four pairs, and
/// sends a message each way.
Checks check_matching();

/// A robot's file (`/etc/muster/<id>.yaml`), and whether this computer is what it says.
Checks check_robot_file(const std::string& path);

/// Domains below 100 whose discovery port on this computer is taken.
std::vector<std::uint32_t> taken_domains();

nlohmann::json to_json(const Checks& checks);
std::string to_text(const Checks& checks, bool colour);

/// `muster doctor [--config FILE] [--no-dds] [--json]`: exit status 1 when something is bad.
void add_doctor_command(CLI::App& app);

}  // namespace muster::command
