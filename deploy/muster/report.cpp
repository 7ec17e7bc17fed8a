#include "deploy/muster/report.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>

#include "common/core/error.h"

namespace muster::command {

void write_report(const std::string& dir) {
  const std::string page = report_page(read_run(dir));
  const std::string path = (std::filesystem::path(dir) / "report.html").string();
  // Written aside and renamed, so that an open browser never loads half a page.
  const std::string aside = path + ".new";
  std::ofstream file(aside, std::ios::binary);
  file << page;
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(aside, path, error);
  if (!file || error) throw Failure(path + ": cannot be written");
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
