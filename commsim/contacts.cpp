#include "commsim/contacts.h"

#include <algorithm>
#include <utility>

namespace muster::commsim {
namespace {

constexpr Duration kSilence{1'000'000}, kApart{30'000'000};

}  // namespace

void Contacts::heard(RobotId from, RobotId by, const mission::Message& message, SimTime at) {
  const Pair pair = std::minmax(from, by);
  Known& known = pairs_[pair];
  known.bytes += message.cdr.size();
  if (message.cls == mission::MessageClass::kMapBlock) known.map_bytes += message.cdr.size();
  if (message.cls == mission::MessageClass::kBeacon) {
    if (begins(known, at)) met_.push_back(pair);
  } else if (known.data_at != at) {
    known.data_at = at;
    ++known.data_ticks;
  }
}

bool Contacts::begins(Known& known, SimTime at) {
  auto& intervals = known.intervals;
  const bool apart = intervals.empty() || at - intervals.back().until > kApart;
  if (intervals.empty() || at - intervals.back().until > kSilence) {
    intervals.push_back({at, at});
  } else {
    intervals.back().until = at;
  }
  known.meetings += apart ? 1 : 0;
  return apart;
}

std::vector<Contacts::Pair> Contacts::take_meetings() { return std::exchange(met_, {}); }

nlohmann::json Contacts::to_json() const {
  auto out = nlohmann::json::array();
  for (const auto& [pair, known] : pairs_) {
    if (known.intervals.empty()) continue;
    auto list = nlohmann::json::array();
    Duration sum;
    for (const Interval& i : known.intervals) {
      list.push_back({i.from.s(), i.until.s()});
      sum = sum + (i.until - i.from);
    }
    out.push_back({{"robots", {pair.first.value, pair.second.value}},
                   {"seconds", sum.s()},
                   {"meetings", known.meetings},
                   {"bytes", known.bytes},
                   {"map_bytes", known.map_bytes},
                   {"data_seconds", (kTick * static_cast<std::int64_t>(known.data_ticks)).s()},
                   {"intervals", std::move(list)}});
  }
  return out;
}

}  // namespace muster::commsim
