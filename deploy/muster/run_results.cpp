#include "deploy/muster/run_results.h"

#include <filesystem>

#include "deploy/muster/report.h"
#include "deploy/muster/summary.h"

namespace muster::command {

void finish_results(const RunOptions& options, const nlohmann::json& summary) {
  write_summary(options.out, summary);
  if (options.report) write_report(options.out);
  // The robots' journals: what counts of them is in station.db.
  std::error_code kept;
  std::filesystem::remove_all(options.out + "/state", kept);
}

}  // namespace muster::command
