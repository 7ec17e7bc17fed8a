#include "deploy/muster/report_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "deploy/muster/report_html.h"

namespace muster::command {
namespace {

using html::number;

std::string percent(double part, double whole) { return number(100 * part / whole, 3) + "%"; }

/// A round step that gives about `count` steps up to `end`, out of `nice`.
double step_for(double end, double count, std::initializer_list<double> nice) {
  for (const double step : nice) {
    if (end / step <= count) return step;
  }
  return std::ceil(end / count);
}

std::string time_axis(const RunData& run) {
  const double step =
      step_for(run.end_s, 9, {5, 10, 20, 30, 60, 120, 180, 300, 600, 900, 1200, 1800, 3600});
  std::string text = "<div class=\"axis\" aria-hidden=\"true\">";
  for (int i = 0; i * step <= run.end_s; ++i) {
    const double t = i * step;
    text += fmt::format("<span{} style=\"left:{}\">{}</span>",
                        t > 0.98 * run.end_s ? " class=\"last\"" : "", percent(t, run.end_s),
                        html::clock(t));
  }
  return text + "</div>";
}

// ---- the site

using Project = double (*)(const RunData::Sample&);

std::string track_path(const RunData::Robot& robot, Project v) {
  std::string path;
  double last_u = 0, last_v = 0;
  for (const auto& s : robot.track) {
    // A decimetre is less than a pixel.
    if (!path.empty() && std::hypot(s.x - last_u, v(s) - last_v) < 0.1) continue;
    last_u = s.x;
    last_v = v(s);
    path += fmt::format("{}{:.1f},{:.1f}", path.empty() ? "M" : " ", last_u, -last_v);
  }
  return path;
}

const char* final_state(const RunData::Feature& f) {
  return f.delivered_s   ? "delivered"
         : f.inspected_s ? "inspected"
         : f.sighted_s   ? "found"
                         : "unseen";
}

std::string drawing(const RunData& run, const ViewFrame& frame, const std::string& light,
                    const std::string& dark, bool elevation) {
  const Project v = elevation ? Project([](const RunData::Sample& s) { return s.z; })
                              : [](const RunData::Sample& s) { return s.y; };
  const double unit = std::max(frame.width(), 12.0) / 100;  // about six pixels
  std::string text = fmt::format("<div class=\"drawing\" style=\"aspect-ratio:{:.3f}/{:.3f}\">",
                                 frame.width(), frame.height());
  if (!light.empty()) {
    text += "<picture><source media=\"(prefers-color-scheme: dark)\" srcset=\"" + dark +
            "\"><img alt=\"\" src=\"" + light + "\"></picture>";
  }
  // SVG's y points down: everything is drawn at −v.
  text +=
      fmt::format("<svg viewBox=\"{:.2f} {:.2f} {:.2f} {:.2f}\" role=\"img\" aria-label=\"{}\">",
                  frame.u0, -frame.v1, frame.width(), frame.height(),
                  elevation ? "The site from the south" : "The site from above");
  for (const auto& f : run.features) {
    text += fmt::format("<circle class=\"feature {}\" cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.3f}\"/>",
                        final_state(f), f.x, -(elevation ? f.z : f.y), 0.42 * unit);
  }
  for (const auto& robot : run.robots) {
    text += fmt::format("<path class=\"track {}\" d=\"{}\"/>", mission::role_name(robot.role),
                        track_path(robot, v));
  }
  for (const auto& robot : run.robots) {
    if (robot.track.empty()) continue;
    const auto& last = robot.track.back();
    text += fmt::format(
        "<g class=\"robot {}{}\" transform=\"translate({:.2f} {:.2f})\"><circle "
        "r=\"{:.3f}\"/><text font-size=\"{:.3f}\">{}</text></g>",
        mission::role_name(robot.role), robot.lost_s ? " lost" : "", last.x, -v(last), 1.15 * unit,
        1.5 * unit, robot.id);
  }
  return text + "</svg></div>";
}

std::string scale_bar(const ViewFrame& frame) {
  const double length = step_for(frame.width(), 6, {1, 2, 5, 10, 20, 50, 100, 200});
  return fmt::format("<div class=\"scale\" style=\"width:{}\"><span>{} m</span></div>",
                     percent(length, frame.width()), number(length));
}

std::string swatch(const std::string& kind, const std::string& label) {
  return "<li><i class=\"" + kind + "\"></i>" + label + "</li>";
}

// ---- features over time

std::vector<double> times(const RunData& run, std::optional<double> RunData::Feature::*when) {
  std::vector<double> all;
  for (const auto& f : run.features) {
    if (f.*when) all.push_back(*(f.*when));
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// A staircase from (0, 0), in seconds and features; y downwards.
std::string staircase(const std::vector<double>& at, double total, double end) {
  std::string path = fmt::format("M0,{}", number(total));
  for (std::size_t i = 0; i < at.size(); ++i) {
    path += fmt::format("H{}V{}", number(at[i], 1), number(total - static_cast<double>(i) - 1));
  }
  return path + "H" + number(end, 1);
}

std::string milestone(const RunData& run, const char* key, const char* label) {
  if (!run.summary.contains(key) || !run.summary[key].is_number()) return "";
  const double t = run.summary[key].get<double>();
  if (t < 0 || t > run.end_s) return "";
  const char* side =
      t > 0.88 * run.end_s || (key == std::string_view("t_94_s") && t > 0.12 * run.end_s) ? " left"
                                                                                          : "";
  return fmt::format("<div class=\"milestone{}\" style=\"left:{}\"><span>{} {}</span></div>", side,
                     percent(t, run.end_s), label, html::clock(t));
}

// ---- timeline

/// What a robot may say it is doing, as in tracks.csv; each is also the name of its colour.
constexpr std::array kActivities = {"exploring",  "inspecting", "meeting", "waiting",
                                    "travelling", "charging",   "holding", "returning",
                                    "landing",    "landed",     "idle",    "lost"};

std::string activity_class(const std::string& activity) {
  const bool known =
      std::find(kActivities.begin(), kActivities.end(), activity) != kActivities.end();
  return known ? activity : "idle";
}

struct Segment {
  double from_s, until_s;
  std::string activity;
};

std::vector<Segment> segments(const RunData::Robot& robot, double end_s) {
  std::vector<Segment> all;
  for (std::size_t i = 0; i < robot.track.size(); ++i) {
    const auto& s = robot.track[i];
    const bool lost = robot.lost_s && s.t_s >= *robot.lost_s;
    const std::string activity = lost ? "lost" : s.activity;
    const double until =
        i + 1 < robot.track.size() ? robot.track[i + 1].t_s : std::min(s.t_s + 1, end_s);
    if (!all.empty() && all.back().activity == activity) {
      all.back().until_s = until;
    } else {
      all.push_back({s.t_s, until, activity});
    }
  }
  if (robot.lost_s && (all.empty() || all.back().until_s < end_s)) {
    all.push_back({all.empty() ? *robot.lost_s : all.back().until_s, end_s, "lost"});
  }
  return all;
}

std::string robot_row(const RunData& run, const RunData::Robot& robot) {
  std::string text = fmt::format("<div class=\"row\"><span class=\"who {}\">{}</span>",
                                 mission::role_name(robot.role), robot_name(robot));
  text +=
      fmt::format("<div class=\"lane\"><svg viewBox=\"0 0 {} 20\" preserveAspectRatio=\"none\">",
                  number(run.end_s, 1));
  for (const Segment& s : segments(robot, run.end_s)) {
    text += fmt::format(
        "<rect class=\"a-{}\" x=\"{}\" width=\"{}\" height=\"15\"><title>{} {}–{}</title></rect>",
        activity_class(s.activity), number(s.from_s, 1), number(s.until_s - s.from_s, 1),
        html::escape(s.activity), html::clock(s.from_s), html::clock(s.until_s));
  }
  for (const auto& c : run.contacts) {
    if (c.a != robot.id && c.b != robot.id) continue;
    const RunData::Robot* other = run.robot(c.a == robot.id ? c.b : c.a);
    if (!other) continue;
    text += fmt::format(
        "<rect class=\"c-{}\" x=\"{}\" y=\"16\" width=\"{}\" height=\"4\"><title>hears {} "
        "{}–{}</title></rect>",
        mission::role_name(other->role), number(c.from_s, 1),
        number(std::max(c.until_s - c.from_s, 0.1), 1), robot_name(*other), html::clock(c.from_s),
        html::clock(c.until_s));
  }
  return text + "</svg></div></div>";
}

std::string activity_legend(const RunData& run) {
  std::string text = "<ul class=\"legend\">";
  for (const std::string name : kActivities) {
    const bool used = std::any_of(run.robots.begin(), run.robots.end(), [&](const auto& robot) {
      return (name == "lost" && robot.lost_s) ||
             std::any_of(robot.track.begin(), robot.track.end(),
                         [&](const auto& s) { return s.activity == name; });
    });
    if (used) text += swatch("a-" + name, name);
  }
  if (!run.contacts.empty()) text += swatch("c-explorer thin", "in contact, coloured by whom with");
  return text + "</ul>";
}

}  // namespace

std::string site_figure(const RunData& run, const SiteViews& views) {
  std::string text = "<figure class=\"site\"><div class=\"views\"><div><h3>From above</h3>";
  text += drawing(run, views.plan, views.plan_light, views.plan_dark, false) +
          scale_bar(views.plan) + "</div><div><h3>From the south</h3>";
  text += drawing(run, views.elevation, views.elevation_light, views.elevation_dark, true);
  text += "<ul class=\"legend stacked\">" + swatch("dot station", "station") +
          swatch("dot explorer", "explorer") + swatch("dot inspector", "inspector");
  if (!run.features.empty()) {
    text += swatch("dot feature unseen", "feature, not found yet") +
            swatch("dot feature found", "found") + swatch("dot feature inspected", "inspected") +
            swatch("dot feature delivered", "delivered to the station");
  }
  text += "</ul></div></div>";
  if (!run.robots.empty()) {
    text += fmt::format(
        "<div class=\"player\" hidden><button type=\"button\" aria-label=\"Play\">▶</button><input "
        "type=\"range\" min=\"0\" max=\"{0}\" value=\"{0}\" "
        "step=\"0.1\" aria-label=\"Mission time\"><output>{1}</output></div>",
        number(run.end_s, 1), html::clock(run.end_s));
  }
  return text + "</figure>";
}

std::string features_figure(const RunData& run) {
  const double total = static_cast<double>(run.features.size());
  const auto found = times(run, &RunData::Feature::sighted_s),
             inspected = times(run, &RunData::Feature::inspected_s),
             delivered = times(run, &RunData::Feature::delivered_s);
  std::string text = "<figure class=\"chart\"><ul class=\"legend\">";
  text += swatch("line found", fmt::format("found <b>{}</b>", found.size())) +
          swatch("line inspected", fmt::format("inspected <b>{}</b>", inspected.size())) +
          swatch("line delivered", fmt::format("delivered <b>{}</b>", delivered.size())) +
          fmt::format("<li class=\"quiet\">of {}</li></ul>", number(total));
  text += "<div class=\"plot scrub\">";
  const double step = step_for(total, 5, {1, 2, 5, 10, 20, 25, 50, 100, 200, 500});
  for (int i = 0; i * step <= total; ++i) {
    const double n = i * step;
    text += fmt::format("<div class=\"grid\" style=\"bottom:{}\"><span>{}</span></div>",
                        percent(n, total), number(n));
  }
  const std::string curve = staircase(delivered, total, run.end_s);
  text += fmt::format(
      "<svg viewBox=\"0 0 {} {}\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"Features "
      "over time\">",
      number(run.end_s, 1), number(total));
  text += fmt::format("<path class=\"area\" d=\"{}V{}H0Z\"/>", curve, number(total));
  text += "<path class=\"found\" d=\"" + staircase(found, total, run.end_s) +
          "\"/><path class=\"inspected\" d=\"" + staircase(inspected, total, run.end_s) +
          "\"/><path class=\"delivered\" d=\"" + curve + "\"/></svg>";
  text += milestone(run, "t_94_s", "94 %") + milestone(run, "t_s", "T") +
          "<div class=\"cursor\"></div></div>" + time_axis(run) + "</figure>";
  return text;
}

std::string timeline_figure(const RunData& run) {
  std::string text = "<figure class=\"chart\">" + activity_legend(run);
  text += run.robots.size() > 16 ? "<div class=\"rows dense\">" : "<div class=\"rows\">";
  // The order of the story: who collects, who maps, who looks.
  for (const auto role :
       {mission::Role::kStation, mission::Role::kExplorer, mission::Role::kInspector}) {
    for (const auto& robot : run.robots) {
      if (robot.role == role) text += robot_row(run, robot);
    }
  }
  return text +
         "<div class=\"over scrub\"><div class=\"cursor\"></div></div></div><div "
         "class=\"under-rows\">" +
         time_axis(run) + "</div></figure>";
}

std::string playback_json(const RunData& run, const std::optional<SiteViews>& views) {
  constexpr std::size_t kMaxSamples = 60'000;  // in all: half a megabyte of text
  std::size_t samples = 0;
  for (const auto& robot : run.robots) samples += robot.track.size();
  const std::size_t stride = samples / kMaxSamples + 1;
  const auto decimetres = [](double v) { return static_cast<long>(std::lround(v * 10)); };

  nlohmann::json robots = nlohmann::json::array(), features = nlohmann::json::array();
  for (const auto& robot : run.robots) {
    nlohmann::json t = nlohmann::json::array(), x = t, y = t, z = t;
    for (std::size_t i = 0; i < robot.track.size();
         i += i + 1 == robot.track.size() ? 1 : std::min(stride, robot.track.size() - 1 - i)) {
      const auto& s = robot.track[i];
      t.push_back(decimetres(s.t_s));
      x.push_back(decimetres(s.x));
      y.push_back(decimetres(s.y));
      z.push_back(decimetres(s.z));
    }
    nlohmann::json one = {{"t", t}, {"x", x}, {"y", y}, {"z", z}};
    if (robot.lost_s) one["lost"] = *robot.lost_s;
    robots.push_back(std::move(one));
  }
  const auto when = [](const std::optional<double>& t) {
    return t ? nlohmann::json(*t) : nlohmann::json(nullptr);
  };
  for (const auto& f : run.features)
    features.push_back({when(f.sighted_s), when(f.inspected_s), when(f.delivered_s)});
  return nlohmann::json{
      {"end", run.end_s}, {"robots", robots}, {"features", features}, {"drawn", views.has_value()}}
      .dump();
}

}  // namespace muster::command
