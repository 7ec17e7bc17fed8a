#include "deploy/muster/doctor.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "common/core/error.h"

namespace muster::command {
namespace {

using Verdict = Check::Verdict;

struct Options {
  std::string config;
  bool json = false, no_dds = false;
};

Checks examine(const Options& options) {
  Checks all;
  const auto add = [&](Checks more) {
    std::move(more.begin(), more.end(), std::back_inserter(all));
  };
  add(check_interfaces());
  add(check_ports());
  add(check_buffers());
  add(check_shared_memory());
  add(check_processes());
  add(check_clock());
  add(check_vendors());
  if (!options.no_dds) add(check_matching());
  if (!options.config.empty()) add(check_robot_file(options.config));
  return all;
}

std::size_t count(const Checks& checks, Verdict verdict) {
  return static_cast<std::size_t>(std::count_if(
      checks.begin(), checks.end(), [&](const Check& c) { return c.verdict == verdict; }));
}

const char* mark(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "ok  ";
    case Verdict::kNote:
      return "note";
    case Verdict::kWarn:
      return "warn";
    case Verdict::kBad:
      return "BAD ";
  }
  return "";
}

const char* colour_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "\033[32m";
    case Verdict::kNote:
      return "\033[2m";
    case Verdict::kWarn:
      return "\033[33m";
    case Verdict::kBad:
      return "\033[1;31m";
  }
  return "";
}

std::string closing_line(const Checks& checks) {
  const std::size_t bad = count(checks, Verdict::kBad), warn = count(checks, Verdict::kWarn);
  if (bad > 0) return std::to_string(bad) + (bad == 1 ? " thing is wrong." : " things are wrong.");
  if (warn > 0)
    return "Fit to fly; " + std::to_string(warn) + (warn == 1 ? " thing" : " things") +
           " could be better.";
  return "Fit to fly.";
}

void run_doctor(const Options& options) {
  const Checks checks = examine(options);
  if (options.json) {
    std::printf("%s\n", to_json(checks).dump(2).c_str());
  } else {
    std::fputs(to_text(checks, isatty(STDOUT_FILENO) != 0).c_str(), stdout);
  }
  if (count(checks, Verdict::kBad) > 0) throw Failure("a mission will fail on what is marked BAD");
}

}  // namespace

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "good";
    case Verdict::kNote:
      return "note";
    case Verdict::kWarn:
      return "warn";
    case Verdict::kBad:
      return "bad";
  }
  return "";
}

nlohmann::json to_json(const Checks& checks) {
  nlohmann::json list = nlohmann::json::array();
  for (const Check& c : checks) {
    list.push_back({{"topic", c.topic},
                    {"found", c.found},
                    {"verdict", to_string(c.verdict)},
                    {"help", c.help}});
  }
  return {{"fit", count(checks, Verdict::kBad) == 0}, {"checks", list}};
}

std::string to_text(const Checks& checks, bool colour) {
  std::string text, topic;
  for (const Check& c : checks) {
    if (c.topic != topic) text += (topic.empty() ? "" : "\n") + c.topic + "\n";
    topic = c.topic;
    text += std::string("  ") + (colour ? colour_of(c.verdict) : "") + mark(c.verdict) +
            (colour ? "\033[0m" : "") + "  " + c.found + "\n";
    if (!c.help.empty()) text += "        → " + c.help + "\n";
  }
  return text + "\n" + closing_line(checks) + "\n";
}

void add_doctor_command(CLI::App& app) {
  CLI::App* doctor = app.add_subcommand(
      "doctor", "Look at network, DDS, clock and leftovers; say what is wrong and what would help");
  auto options = std::make_shared<Options>();
  doctor->add_option("--config", options->config,
                     "also check a robot's file, e.g. /etc/muster/3.yaml, against this computer");
  doctor->add_flag("--no-dds", options->no_dds,
                   "skip the trial in which both vendors meet each other");
  doctor->add_flag("--json", options->json, "for machines");
  doctor->footer(
      "Changes nothing. Exit status 0: fit to fly, perhaps with warnings; 1: something is wrong; "
      "2: the robot's file is.");
  doctor->callback([options] { run_doctor(*options); });
}

}  // namespace muster::command
