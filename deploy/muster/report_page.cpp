#include <algorithm>
#include <array>
#include <cmath>

#include "deploy/muster/report.h"
#include "deploy/muster/report_charts.h"
#include "deploy/muster/report_html.h"
#include "deploy/muster/report_map.h"

namespace muster::command {
namespace {

using html::escape;
using html::number;
using nlohmann::json;

std::optional<double> figure(const RunData& run, const char* key) {
  if (!run.summary.contains(key) || !run.summary[key].is_number()) return std::nullopt;
  return run.summary[key].get<double>();
}

std::string text_of(const RunData& run, const char* key, const std::string& otherwise = "") {
  if (!run.summary.contains(key)) return otherwise;
  const json& value = run.summary[key];
  return value.is_string() ? value.get<std::string>() : value.is_null() ? otherwise : value.dump();
}

// ---- the result in words

std::string headline(const RunData& run) {
  const auto t = figure(run, "t_s"), finish = figure(run, "finish_time_s");
  if (run.complete())
    return t        ? "Complete in " + html::spoken(*t)
           : finish ? "Complete in " + html::spoken(*finish)
                    : "Complete";
  if (run.summary.empty()) return "Cut short after " + html::spoken(run.end_s);
  if (finish) return "Declared complete, but it was not";
  return "Not complete after " + html::spoken(run.end_s);
}

std::string count_of(std::size_t n, const std::string& what) {
  static constexpr std::array kWords = {"no",  "one",   "two",   "three", "four", "five",
                                        "six", "seven", "eight", "nine",  "ten"};
  return (n < kWords.size() ? kWords[n] : std::to_string(n)) + (" " + what) + (n == 1 ? "" : "s");
}

std::string lede(const RunData& run) {
  std::array<std::size_t, 3> roles{};
  for (const auto& robot : run.robots) ++roles[static_cast<std::size_t>(robot.role)];
  std::string text;
  if (!run.robots.empty()) {
    text = count_of(roles[0], "station") + ", " + count_of(roles[1], "explorer") + " and " +
           count_of(roles[2], "inspector");
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  }
  const auto total = figure(run, "features_total"), delivered = figure(run, "features_delivered");
  if (!text.empty() && total && delivered) {
    text += *delivered >= *total
                ? " found, inspected and brought home all " + number(*total) + " features."
                : " brought home " + number(*delivered) + " of " + number(*total) + " features.";
  } else if (!text.empty()) {
    text += ".";
  }
  const std::string ended = text_of(run, "ended");
  if (!run.complete() && !ended.empty()) text += " The run ended: " + ended + ".";
  return text;
}

std::string lost_line(const RunData& run) {
  std::string text;
  for (const auto& robot : run.robots) {
    if (robot.lost_s)
      text += (text.empty() ? "" : ", ") + robot_name(robot) + " at " + html::clock(*robot.lost_s);
  }
  return text.empty() ? "" : "<p class=\"callout\"><b>Lost on the way:</b> " + text + ".</p>";
}

// ---- tiles

std::string tile(const std::string& label, const std::string& value, const std::string& unit,
                 const char* verdict = "") {
  return "<div class=\"tile " + std::string(verdict) + "\"><dt>" + label + "</dt><dd>" + value +
         (unit.empty() ? "" : "<small>" + unit + "</small>") + "</dd></div>";
}

std::string tiles(const RunData& run) {
  std::string text = "<dl class=\"tiles\">";
  const auto t = figure(run, "t_s");
  text += tile("Time T", t ? html::clock(*t) : "–", t ? (*t < 3600 ? "min" : "h") : "not reached",
               t ? "" : "bad");
  const auto total = figure(run, "features_total"), delivered = figure(run, "features_delivered");
  if (total && delivered)
    text += tile("Features delivered", number(*delivered), "of " + number(*total),
                 *delivered < *total ? "bad" : "good");
  if (const auto c = figure(run, "map_coverage"))
    text += tile("Map coverage", number(100 * *c, 1), "%", *c < 0.95 ? "bad" : "good");
  if (const auto c = figure(run, "collisions"))
    text += tile("Collisions", number(*c), "", *c > 0 ? "bad" : "good");
  if (const auto c = figure(run, "min_clearance_m"))
    text += tile("Closest to the site", number(*c), "m");
  if (const auto c = figure(run, "real_time_factor"))
    text += tile("Simulated at", number(*c, 1), "× real time");
  return text + "</dl>";
}

// ---- every number

std::string leaf(const json& value) {
  if (value.is_null()) return "<span class=\"quiet\">–</span>";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float())
    return number(value.get<double>(), std::abs(value.get<double>()) < 1 ? 4 : 2);
  if (value.is_string()) return escape(value.get<std::string>());
  return escape(value.dump());
}

void add_rows(std::string& text, const std::string& name, const json& value) {
  if (value.is_object()) {
    for (const auto& [key, inner] : value.items())
      add_rows(text, name + "<i>.</i>" + escape(key), inner);
    return;
  }
  if (value.is_array() && !value.empty() && value.front().is_structured()) {
    text += "<tr><th>" + name + "</th><td>" + std::to_string(value.size()) +
            (value.size() == 1 ? " entry" : " entries") + "</td></tr>";
    return;
  }
  text += "<tr><th>" + name + "</th><td>" + leaf(value) + "</td></tr>";
}

std::string planning_table(const json& planning) {
  std::string text =
      "<table "
      "class=\"grid-table\"><thead><tr><th>step</th><th>count</th><th>mean</th><th>p95</"
      "th><th>max</th></tr></thead><tbody>";
  for (const auto& [step, values] : planning.items()) {
    if (!values.is_object()) continue;
    text += "<tr><th>" + escape(step) + "</th>";
    for (const char* key : {"count", "mean", "p95", "max"}) {
      text += "<td>" +
              (values.contains(key) && values[key].is_number() ? number(values[key].get<double>())
                                                               : "–") +
              "</td>";
    }
    text += "</tr>";
  }
  return text + "</tbody></table>";
}

std::string numbers_section(const RunData& run) {
  if (run.summary.empty()) return "";
  std::string text =
      "<section><h2>Every number</h2><div class=\"columns\"><table class=\"numbers\"><tbody>";
  for (const auto& [key, value] : run.summary.items()) {
    if (key != "planning_ms" && key != "contacts") add_rows(text, escape(key), value);
  }
  text += "</tbody></table></div>";
  if (run.summary.contains("planning_ms") && run.summary["planning_ms"].is_object() &&
      !run.summary["planning_ms"].empty()) {
    text += "<h3>Planning, in milliseconds of wall clock</h3>" +
            planning_table(run.summary["planning_ms"]);
  }
  return text + "</section>";
}

std::string section(const std::string& title, const std::string& says, const std::string& body) {
  return "<section><h2>" + title + "</h2><p class=\"says\">" + says + "</p>" + body + "</section>";
}

std::string fact(const std::string& value) {
  return value.empty() ? "" : "<li>" + escape(value) + "</li>";
}

std::string header(const RunData& run) {
  const std::string mission = text_of(run, "mission", "a mission");
  std::string text = "<header><ul class=\"facts\"><li class=\"name\">" + escape(mission) + "</li>" +
                     fact(text_of(run, "strategy"));
  const std::string seed = text_of(run, "seed"), transport = text_of(run, "transport"),
                    dds = text_of(run, "dds");
  text += fact(seed.empty() ? "" : "seed " + seed) +
          fact(transport == "memory" ? "in memory" : dds) + "</ul>";
  return text + "<h1>" + headline(run) + "</h1><p class=\"lede\">" + escape(lede(run)) + "</p>" +
         lost_line(run) + "</header>";
}

std::string footer(const RunData& run) {
  std::string text = "<footer>";
  if (!run.notes.empty()) {
    text += "<p>Not shown: ";
    for (std::size_t i = 0; i < run.notes.size(); ++i)
      text += (i > 0 ? "; " : "") + escape(run.notes[i]);
    text += ".</p>";
  }
  const std::string trace = text_of(run, "trace_hash");
  return text + "<p>Muster" + (trace.empty() ? "" : " · trace <code>" + escape(trace) + "</code>") +
         "</p></footer>";
}

}  // namespace

std::string report_page(RunData run) {
  const std::optional<SiteViews> views = draw_site(run);
  std::string text =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\">";
  text += "<meta name=\"color-scheme\" content=\"light dark\"><title>" +
          escape(text_of(run, "mission", "Mission")) + ": " + headline(run) + "</title><style>" +
          kReportStyle + "</style></head><body><main>";
  text += header(run) + tiles(run);
  if (views) {
    text += section("The site",
                    "As the station knows it at the end, with everybody’s track. Move the time to "
                    "watch them fly.",
                    site_figure(run, *views));
  }
  if (!run.features.empty()) {
    text += section("Features",
                    "Found by explorers, inspected by inspectors, and delivered once the station "
                    "holds the result.",
                    features_figure(run));
  }
  if (!run.robots.empty())
    text += section("Who did what, when", "As each robot said itself, second by second.",
                    timeline_figure(run));
  text += numbers_section(run) + footer(run) + "</main>";
  text += "<script type=\"application/json\" id=\"run\">" + playback_json(run, views) +
          "</script><script>" + kReportScript + "</script></body></html>\n";
  return text;
}

}  // namespace muster::command
