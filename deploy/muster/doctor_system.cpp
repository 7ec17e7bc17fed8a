#include <sys/timex.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "deploy/muster/doctor.h"

namespace muster::command {
namespace {

namespace fs = std::filesystem;
using Verdict = Check::Verdict;

std::string first_line(const std::string& path) {
  std::string line;
  std::ifstream file(path);
  std::getline(file, line);
  return line;
}

bool is_number(const std::string& text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
}

}  // namespace

/// Killed processes leave their DDS shared memory behind. Ours use none (DESIGN "The DDS layer"),
/// so whatever is there is another's.
Checks check_shared_memory(const std::string& folder) {
  std::size_t files = 0;
  std::uintmax_t bytes = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const bool dds = name.rfind("fastrtps_", 0) == 0 || name.rfind("fast_datasharing", 0) == 0 ||
                     name.rfind("sem.fastrtps", 0) == 0 || name.rfind("iceoryx", 0) == 0;
    if (!dds) continue;
    ++files;
    const std::uintmax_t size = fs::file_size(entry.path(), error);
    if (!error) bytes += size;
  }
  if (files == 0) return {{"Leftovers", "no DDS shared memory in " + folder, Verdict::kGood, ""}};
  const std::string found = std::to_string(files) + " DDS files in " + folder + ", " +
                            std::to_string(bytes / 1'000'000) + " MB";
  return {{"Leftovers", found, bytes > 100'000'000 ? Verdict::kWarn : Verdict::kNote,
           "when no DDS program is running: rm " + folder + "/*fastrtps_* " + folder +
               "/fast_datasharing*"}};
}

Checks check_processes() {
  Checks checks;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/proc", error)) {
    const std::string pid = entry.path().filename().string();
    if (!is_number(pid) || pid == std::to_string(getpid())) continue;
    const std::string name = first_line(entry.path() / "comm");
    if (name.rfind("muster", 0) == 0)
      checks.push_back({"Leftovers", name + " is running as process " + pid, Verdict::kNote, ""});
  }
  if (checks.empty())
    checks.push_back({"Leftovers", "no process of ours is running", Verdict::kGood, ""});
  return checks;
}

Checks check_clock() {
  Checks checks;
  const std::string source =
      first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  timespec step{};
  clock_getres(CLOCK_MONOTONIC, &step);
  const long step_ns = step.tv_nsec + step.tv_sec * 1'000'000'000L;
  const std::string found = "monotonic clock from " +
                            (source.empty() ? std::string("an unknown source") : source) +
                            ", resolution " + std::to_string(step_ns) + " ns";
  const bool coarse = step_ns > 1'000'000;
  checks.push_back(
      {"Clock", found, coarse ? Verdict::kWarn : Verdict::kGood,
       coarse
           ? "steps above 1 ms disturb flight in real time; the kernel needs high-resolution timers"
           : ""});

  // Mission time never comes from here; only file names and epochs do.
  timex state{};
  const bool synchronised = adjtimex(&state) != TIME_ERROR && !(state.status & STA_UNSYNC);
  checks.push_back(
      {"Clock",
       synchronised ? "the system clock is synchronised"
                    : "the system clock is not synchronised: only names of files and epochs suffer",
       synchronised ? Verdict::kGood : Verdict::kNote, ""});
  return checks;
}

}  // namespace muster::command
