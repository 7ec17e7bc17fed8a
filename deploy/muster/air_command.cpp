#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "deploy/muster/air.h"
#include "deploy/muster/report_html.h"
#include "deploy/muster/write_file.h"

namespace muster::command {
namespace {

std::string short_name(const RunData& run, std::uint32_t id) {
  const RunData::Robot* robot = run.robot(id);
  return robot ? robot_name(*robot) : fmt::format("robot {}", id);
}

std::string size(std::uint64_t bytes) {
  if (bytes < 10'000) return fmt::format("{} B", bytes);
  if (bytes < 10'000'000) return fmt::format("{:.0f} kB", static_cast<double>(bytes) / 1e3);
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

std::string reasons(const std::map<std::string, std::uint64_t>& dropped) {
  std::string text;
  for (const auto& [reason, n] : dropped) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", reason, n);
  }
  return text.empty() ? "–" : text;
}

std::map<std::string, std::uint64_t> both(const AirData::Pair& pair) {
  auto sum = pair.from_a.dropped;
  for (const auto& [reason, n] : pair.from_b.dropped) sum[reason] += n;
  return sum;
}

nlohmann::json way_json(const AirData::Way& way, std::uint32_t from, std::uint32_t to) {
  auto moments = nlohmann::json::array();
  for (const AirData::Moment& m : way.moments) moments.push_back({m.t_s, m.bytes, m.lost});
  return {{"from", from},
          {"to", to},
          {"messages", way.messages},
          {"bytes", way.bytes},
          {"dropped_bytes", way.dropped_bytes},
          {"dropped", way.dropped},
          {"moments", std::move(moments)}};
}

std::string meetings_text(const AirData::Meetings& m) {
  if (m.count == 0 || m.together_s <= 0) return "";
  std::string text = fmt::format(
      "meetings: {}, {} heard in each, {} of it map; for {:.0f} % of the contact time records came "
      "through\n",
      m.count, size(m.bytes / m.count), size(m.map_bytes / m.count), 100 * m.data_s / m.together_s);
  if (m.whole_map_bytes && m.whole_octree_bytes && m.map_bytes_sent > 0) {
    const auto times = [&](std::uint64_t bytes) {
      return fmt::format("{}, {:.1f} times as much", size(bytes),
                         static_cast<double>(bytes) / static_cast<double>(m.map_bytes_sent));
    };
    text += fmt::format(
        "map: {} sent; had both sent all of theirs at each meeting: as OctoMap's octrees (.bt) {}; "
        "as zstd packs our own blocks {}\n",
        size(m.map_bytes_sent), times(*m.whole_octree_bytes), times(*m.whole_map_bytes));
  }
  return text;
}

nlohmann::json meetings_json(const AirData::Meetings& m) {
  nlohmann::json json{{"count", m.count},           {"bytes", m.bytes},
                      {"map_bytes", m.map_bytes},   {"together_s", m.together_s},
                      {"data_s", m.data_s},         {"map_bytes_sent", m.map_bytes_sent},
                      {"whole_map_bytes", nullptr}, {"whole_octree_bytes", nullptr}};
  if (m.whole_map_bytes) json["whole_map_bytes"] = *m.whole_map_bytes;
  if (m.whole_octree_bytes) json["whole_octree_bytes"] = *m.whole_octree_bytes;
  return json;
}

}  // namespace

std::string air_table(const AirData& air) {
  std::string text = fmt::format("{:<28} {:>8} {:>8} {:>9} {:>9} {:>9}  {}\n", "who", "together",
                                 "contacts", "apart", "a to b", "b to a", "dropped");
  std::string never;
  for (const AirData::Pair& pair : air.pairs) {
    const std::string who = short_name(air.run, pair.a) + ", " + short_name(air.run, pair.b);
    if (!pair.ever()) {
      never += fmt::format("{}{}–{}", never.empty() ? "" : ", ", pair.a, pair.b);
      continue;
    }
    text +=
        fmt::format("{:<28} {:>8} {:>8} {:>9} {:>9} {:>9}  {}\n", who, html::clock(pair.together_s),
                    pair.contacts.size(), html::clock(pair.longest_apart_s),
                    size(pair.from_a.bytes), size(pair.from_b.bytes), reasons(both(pair)));
  }
  if (!never.empty()) text += fmt::format("never heard each other: {}\n", never);
  text += fmt::format("dropped in all: {}\n", reasons(air.dropped()));
  text += meetings_text(air.meetings);
  return text;
}

nlohmann::json air_json(const AirData& air) {
  auto pairs = nlohmann::json::array();
  for (const AirData::Pair& pair : air.pairs) {
    pairs.push_back(
        {{"robots", {pair.a, pair.b}},
         {"together_s", pair.together_s},
         {"longest_apart_s", pair.longest_apart_s},
         {"contacts", pair.contacts},
         {"ways", {way_json(pair.from_a, pair.a, pair.b), way_json(pair.from_b, pair.b, pair.a)}}});
  }
  return {{"end_s", air.run.end_s},
          {"moment_s", air.step_s},
          {"dropped", air.dropped()},
          {"meetings", meetings_json(air.meetings)},
          {"pairs", std::move(pairs)}};
}

void add_air_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "air", "Who heard whom in a run, when, how much, and what was dropped and why");
  auto dir = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  command->add_option("DIR", *dir, "the directory of a run (its --out)")->required();
  command->add_flag("--json", *json, "one JSON object on stdout, and no page");
  command->footer(
      "Prints a table and draws DIR/air.html: a row per pair with its contacts and what was heard "
      "when.\n"
      "together, contacts: as beacons were heard; apart: the longest time without. A contact after "
      "more\n"
      "than 30 s apart is a meeting; what sending whole maps would have cost is known after "
      "--transport memory.\n"
      "Reasons: range (too far), wall, loss (faded, or drawn), airtime (the air was busy for too "
      "long),\n"
      "dead (one of the two was), and by the mission's script: jam, cut, paused, scripted "
      "(muted);\n"
      "pose: in a lab, one of the two was out of sight.\n"
      "The record is DIR/air.csv.");
  command->callback([dir, json] {
    const AirData air = read_air(*dir);
    if (*json) {
      fmt::print("{}\n", air_json(air).dump());
      return;
    }
    const std::string path = (std::filesystem::path(*dir) / "air.html").string();
    write_file(path, air_page(air));
    fmt::print("{}{}\n", air_table(air), path);
  });
}

}  // namespace muster::command
