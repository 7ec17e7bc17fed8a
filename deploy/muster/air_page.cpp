#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "deploy/muster/air.h"
#include "deploy/muster/report.h"
#include "deploy/muster/report_html.h"

namespace muster::command {
namespace {

using html::number;

constexpr double kHalf = 20;  // a lane's height above and below its middle, in its own units
constexpr std::size_t kMaxColumns = 400;

constexpr const char* kAirStyle = R"css(
.air .row{height:46px;border-bottom:1px solid var(--rule)}.air .lane{height:40px}.air .who{width:190px;color:var(--ink)}
.air .over,.air.under{left:190px}.under-air .axis{margin-left:190px}
.air.dense .row{height:26px}.air.dense .lane{height:22px}
.near{fill:var(--sunk)}.way-a{fill:var(--explorer)}.way-b{fill:var(--inspector)}.lost-here{fill:var(--lost)}
.middle{stroke:var(--soft);stroke-width:.5;vector-effect:non-scaling-stroke}
.legend i.way-a{background:var(--explorer)}.legend i.way-b{background:var(--inspector)}.legend i.near{background:var(--sunk);border:1px solid var(--rule)}
.legend i.lost-here{background:var(--lost)}
)css";

struct Columns {
  double width_s;
  std::size_t count;
};

Columns columns_for(const AirData& air) {
  const double wished = air.run.end_s / static_cast<double>(kMaxColumns);
  const double width_s = air.step_s * std::max(1.0, std::ceil(wished / air.step_s));
  return {width_s, static_cast<std::size_t>(air.run.end_s / width_s) + 1};
}

struct Lane {
  std::vector<double> bytes, lost;
};

Lane lane_of(const AirData::Way& way, const Columns& columns) {
  Lane lane{std::vector<double>(columns.count), std::vector<double>(columns.count)};
  for (const AirData::Moment& m : way.moments) {
    const auto c = std::min(static_cast<std::size_t>(m.t_s / columns.width_s), columns.count - 1);
    lane.bytes[c] += static_cast<double>(m.bytes);
    lane.lost[c] += static_cast<double>(m.lost);
  }
  return lane;
}

double most_bytes(const AirData& air, const Columns& columns) {
  double most = 1;
  for (const AirData::Pair& pair : air.pairs) {
    for (const AirData::Way* way : {&pair.from_a, &pair.from_b}) {
      const Lane lane = lane_of(*way, columns);
      most = std::max(most, *std::ranges::max_element(lane.bytes));
    }
  }
  return most;
}

/// One column for each stretch of time in which something was heard: its height is the logarithm
/// of the bytes, so that a beacon is seen beside a map. `up`: −1 above the middle, 1 below.
std::string heard_path(const Lane& lane, const Columns& columns, double most, int up,
                       const char* cls) {
  std::string d;
  for (std::size_t c = 0; c < columns.count; ++c) {
    if (lane.bytes[c] <= 0) continue;
    const double h = 2 + (kHalf - 3) * std::log1p(lane.bytes[c]) / std::log1p(most);
    d += fmt::format("M{} {}v{}h{}v{}z", number(static_cast<double>(c) * columns.width_s, 1),
                     number(kHalf), number(up * h, 1), number(columns.width_s, 1),
                     number(-up * h, 1));
  }
  return d.empty() ? "" : fmt::format("<path class=\"{}\" d=\"{}\"/>", cls, d);
}

std::string lost_path(const Lane& a, const Lane& b, const Columns& columns) {
  std::string d;
  for (std::size_t c = 0; c < columns.count; ++c) {
    if (a.lost[c] + b.lost[c] <= 0) continue;
    d += fmt::format("M{} {}h{}v2h-{}z", number(static_cast<double>(c) * columns.width_s, 1),
                     number(kHalf - 1), number(columns.width_s, 1), number(columns.width_s, 1));
  }
  return d.empty() ? "" : "<path class=\"lost-here\" d=\"" + d + "\"/>";
}

std::string name_of(const RunData& run, std::uint32_t id) {
  const RunData::Robot* robot = run.robot(id);
  return robot ? robot_name(*robot) : fmt::format("robot {}", id);
}

std::string pair_row(const AirData& air, const AirData::Pair& pair, const Columns& columns,
                     double most) {
  const Lane a = lane_of(pair.from_a, columns), b = lane_of(pair.from_b, columns);
  std::string text = fmt::format(
      "<div class=\"row\"><span class=\"who\">{}, {}</span><div class=\"lane\"><svg viewBox=\"0 0 "
      "{} {}\" preserveAspectRatio=\"none\">",
      name_of(air.run, pair.a), name_of(air.run, pair.b), number(air.run.end_s, 1),
      number(2 * kHalf));
  for (const auto& [from_s, until_s] : pair.contacts) {
    text += fmt::format(
        "<rect class=\"near\" x=\"{}\" width=\"{}\" height=\"{}\"><title>in contact "
        "{}–{}</title></rect>",
        number(from_s, 1), number(std::max(until_s - from_s, 0.5), 1), number(2 * kHalf),
        html::clock(from_s), html::clock(until_s));
  }
  text += fmt::format("<line class=\"middle\" x1=\"0\" x2=\"{}\" y1=\"{}\" y2=\"{}\"/>",
                      number(air.run.end_s, 1), number(kHalf), number(kHalf));
  return text + heard_path(a, columns, most, -1, "way-a") +
         heard_path(b, columns, most, 1, "way-b") + lost_path(a, b, columns) + "</svg></div></div>";
}

std::string time_axis(double end_s) {
  constexpr double kSteps[] = {10, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200};
  const auto step = std::ranges::find_if(kSteps, [&](double s) { return end_s / s <= 8; });
  const double step_s = step == std::end(kSteps) ? 14'400 : *step;
  std::string text = "<div class=\"axis\">";
  for (int i = 0; i * step_s <= end_s; ++i) {
    const double t = i * step_s;
    text +=
        fmt::format("<span style=\"left:{}%\">{}</span>", number(100 * t / end_s), html::clock(t));
  }
  return text + "</div>";
}

std::string swatch(const char* cls, const std::string& label) {
  return fmt::format("<li><i class=\"{}\"></i>{}</li>", cls, label);
}

std::string timeline(const AirData& air) {
  const Columns columns = columns_for(air);
  const double most = most_bytes(air, columns);
  std::string rows;
  std::size_t count = 0;
  for (const AirData::Pair& pair : air.pairs) {
    if (!pair.ever()) continue;
    rows += pair_row(air, pair, columns, most);
    ++count;
  }
  if (count == 0) return "<p class=\"says\">Nobody ever heard anybody.</p>";
  return "<figure class=\"chart\"><ul class=\"legend\">" + swatch("near", "in contact") +
         swatch("way-a", "the second heard the first") +
         swatch("way-b", "the first heard the second") +
         swatch("lost-here", "lost on the way, no airtime, jammed or cut") +
         fmt::format("<li>columns: bytes in {} s, by their logarithm, at most {} kB</li></ul>",
                     number(columns.width_s), number(most / 1000)) +
         fmt::format("<div class=\"rows air{}\">", count > 24 ? " dense" : "") + rows +
         "</div><div class=\"under-air\">" + time_axis(air.run.end_s) + "</div></figure>";
}

std::string cell(const std::map<std::string, std::uint64_t>& of, const std::string& key) {
  const auto at = of.find(key);
  return at == of.end() ? "<td class=\"quiet\">–</td>" : fmt::format("<td>{}</td>", at->second);
}

std::string table(const AirData& air) {
  const auto reasons = air.dropped();
  std::string text =
      "<table class=\"grid-table\"><thead><tr><th>from, to</th><th>together</th><th>contacts</th>"
      "<th>longest apart</th><th>heard</th><th>kB</th>";
  for (const auto& [reason, n] : reasons) text += "<th>" + html::escape(reason) + "</th>";
  text += "</tr></thead><tbody>";
  for (const AirData::Pair& pair : air.pairs) {
    for (const AirData::Way* way : {&pair.from_a, &pair.from_b}) {
      const bool forth = way == &pair.from_a;
      text += fmt::format(
          "<tr><th>{} → {}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
          name_of(air.run, forth ? pair.a : pair.b), name_of(air.run, forth ? pair.b : pair.a),
          html::clock(pair.together_s), pair.contacts.size(), html::clock(pair.longest_apart_s),
          way->messages, number(static_cast<double>(way->bytes) / 1000, 1));
      for (const auto& [reason, n] : reasons) text += cell(way->dropped, reason);
      text += "</tr>";
    }
  }
  return text + "</tbody></table>";
}

std::string facts(const AirData& air) {
  const auto& s = air.run.summary;
  std::string text = "<ul class=\"facts\">";
  const auto add = [&](const std::string& fact) { text += "<li>" + html::escape(fact) + "</li>"; };
  if (s.contains("mission") && s["mission"].is_string()) add(s["mission"].get<std::string>());
  if (s.contains("seed")) add("seed " + s["seed"].dump());
  if (s.contains("settings") && s["settings"].contains("radio")) {
    add("radio " + s["settings"]["radio"].get<std::string>());
  }
  return text + "<li>" + html::spoken(air.run.end_s) + "</li></ul>";
}

}  // namespace

std::string air_page(const AirData& air) {
  return std::string(
             "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta "
             "name=\"viewport\" content=\"width=device-width\"><title>Air</title><style>") +
         kReportStyle + kAirStyle + "</style></head><body><main>" + facts(air) +
         "<h1>Who heard whom</h1><section><h2>When</h2>" + timeline(air) +
         "</section><section><h2>How much, and what was dropped</h2>"
         "<p class=\"says\">Messages, by the reason they were not heard: too far, a wall, lost "
         "(faded or drawn), no airtime, one of the two dead; jam, cut, paused and scripted: taken "
         "away by the mission's script.</p>" +
         table(air) + "</section></main></body></html>\n";
}

}  // namespace muster::command
