#include "deploy/muster/report.h"

#include <cstdio>
#include <filesystem>
#include <memory>

#include "deploy/muster/write_file.h"

namespace muster::command {

void write_report(const std::string& dir) {
  const std::string page = report_page(read_run(dir));
  write_file((std::filesystem::path(dir) / "report.html").string(), page);
}

void add_report_command(CLI::App& app) {
  CLI::App* report =
      app.add_subcommand("report", "Turn a run into one self-contained page, DIR/report.html");
  auto dir = std::make_shared<std::string>();
  report->add_option("DIR", *dir, "the directory of a run (its --out)")->required();
  report->footer(
      "Shows the result, the site with everybody's tracks, features over time, who did what when, "
      "and every number of\n"
      "summary.json. A run that was cut short is shown as far as it went.");
  report->callback([dir] {
    write_report(*dir);
    std::printf("%s\n", (std::filesystem::path(*dir) / "report.html").c_str());
  });
}

}  // namespace muster::command
