#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "common/core/error.h"
#include "deploy/muster/air.h"
#include "deploy/muster/csv.h"

namespace fs = std::filesystem;
using namespace nlohmann::literals;

namespace muster::command {
namespace {

constexpr std::size_t kFixedColumns = 6;  // then one for each reason

/// The numbers of a row; none when it is not whole (a run that was cut short ends in the middle).
std::vector<std::uint64_t> numbers(std::string_view line, std::size_t columns) {
  std::vector<std::uint64_t> out;
  for (const std::string_view cell : cells_of(line)) {
    const auto value = number_in<std::uint64_t>(cell);
    if (!value) return {};
    out.push_back(*value);
  }
  if (out.size() != columns) out.clear();
  return out;
}

AirData::Pair& pair_of(AirData& air, std::uint32_t x, std::uint32_t y) {
  const auto [a, b] = std::minmax(x, y);
  const auto key = [](const AirData::Pair& p) { return std::pair(p.a, p.b); };
  const auto at = std::ranges::lower_bound(air.pairs, std::pair(a, b), {}, key);
  if (at != air.pairs.end() && key(*at) == std::pair(a, b)) return *at;
  AirData::Pair fresh;
  fresh.a = a, fresh.b = b;
  return *air.pairs.insert(at, std::move(fresh));
}

/// Neither distance nor walls nor the hearer's silence explain it.
bool unexplained(const std::string& reason) {
  return reason == "loss" || reason == "airtime" || reason == "jam" || reason == "cut";
}

void add_row(AirData& air, const std::vector<std::string>& reasons,
             const std::vector<std::uint64_t>& row) {
  const auto from = static_cast<std::uint32_t>(row[1]), to = static_cast<std::uint32_t>(row[2]);
  AirData::Pair& pair = pair_of(air, from, to);
  AirData::Way& way = from == pair.a ? pair.from_a : pair.from_b;
  way.messages += row[3];
  way.bytes += row[4];
  way.dropped_bytes += row[5];
  std::uint64_t lost = 0;
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    const std::uint64_t n = row[kFixedColumns + i];
    if (n > 0) way.dropped[reasons[i]] += n;
    if (unexplained(reasons[i])) lost += n;
  }
  if (row[4] > 0 || lost > 0) way.moments.push_back({static_cast<double>(row[0]), row[4], lost});
}

void read_csv(AirData& air, const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) {
    throw BadInput(path +
                   ": missing: the run had no simulated radio (--link direct), or ended "
                   "before it began");
  }
  std::vector<std::string> reasons;
  const auto header = cells_of(line);
  for (std::size_t i = kFixedColumns; i < header.size(); ++i) reasons.emplace_back(header[i]);
  while (std::getline(file, line)) {
    const auto row = numbers(line, header.size());
    if (!row.empty()) add_row(air, reasons, row);
  }
}

void add_contacts(AirData& air) {
  for (const RunData::Contact& c : air.run.contacts) {
    pair_of(air, c.a, c.b).contacts.emplace_back(c.from_s, c.until_s);
  }
  for (AirData::Pair& pair : air.pairs) {
    std::ranges::sort(pair.contacts);
    double since_s = 0;
    for (const auto& [from_s, until_s] : pair.contacts) {
      pair.together_s += until_s - from_s;
      pair.longest_apart_s = std::max(pair.longest_apart_s, from_s - since_s);
      since_s = until_s;
    }
    pair.longest_apart_s = std::max(pair.longest_apart_s, air.run.end_s - since_s);
  }
}

/// As the radio counted them (commsim/relay.h).
void add_meetings(AirData& air) {
  AirData::Meetings& m = air.meetings;
  const nlohmann::json& summary = air.run.summary;
  try {
    for (const auto& pair : summary.value("contacts", nlohmann::json::array())) {
      m.count += pair.value("meetings", std::uint64_t{0});
      m.bytes += pair.value("bytes", std::uint64_t{0});
      m.map_bytes += pair.value("map_bytes", std::uint64_t{0});
      m.together_s += pair.value("seconds", 0.0);
      m.data_s += pair.value("data_seconds", 0.0);
    }
    m.map_bytes_sent =
        summary.value("/air/by_topic/map_block/bytes"_json_pointer, std::uint64_t{0});
    const auto whole = [&](const char* key) -> std::optional<std::uint64_t> {
      const auto at = nlohmann::json::json_pointer(std::string("/air/") + key);
      const auto bytes = summary.value(at, std::uint64_t{0});
      return bytes > 0 ? std::optional(bytes) : std::nullopt;
    };
    m.whole_map_bytes = whole("whole_map_bytes");
    m.whole_octree_bytes = whole("whole_octree_bytes");
  } catch (const nlohmann::json::exception&) {
    air.run.notes.push_back("what summary.json says of the air is damaged");
  }
}

}  // namespace

std::map<std::string, std::uint64_t> AirData::dropped() const {
  std::map<std::string, std::uint64_t> sum;
  for (const Pair& pair : pairs) {
    for (const Way* way : {&pair.from_a, &pair.from_b}) {
      for (const auto& [reason, n] : way->dropped) sum[reason] += n;
    }
  }
  return sum;
}

AirData read_air(const std::string& dir) {
  AirData air;
  air.run = read_run(dir);
  read_csv(air, (fs::path(dir) / "air.csv").string());
  add_contacts(air);
  add_meetings(air);
  return air;
}

}  // namespace muster::command
