#include "deploy/muster/run_results.h"

#include "deploy/muster/report.h"
#include "deploy/muster/summary.h"

namespace muster::command {

void finish_results(const RunOptions& options, const nlohmann::json& summary) {
  write_summary(options.out, summary);
  if (options.report) write_report(options.out);
}

}  // namespace muster::command
