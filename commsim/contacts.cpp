#include "commsim/contacts.h"

#include <algorithm>

namespace muster::commsim {
namespace {

constexpr Duration kSilence{1'000'000};

}  // namespace

void Contacts::beacon_heard(RobotId from, RobotId by, SimTime at) {
  std::vector<Interval>& intervals = pairs_[std::minmax({from, by})];
  if (intervals.empty() || at - intervals.back().until > kSilence) {
    intervals.push_back({at, at});
  } else {
    intervals.back().until = at;
  }
}

nlohmann::json Contacts::to_json() const {
  auto out = nlohmann::json::array();
  for (const auto& [pair, intervals] : pairs_) {
    auto list = nlohmann::json::array();
    Duration sum;
    for (const Interval& i : intervals) {
      list.push_back({i.from.s(), i.until.s()});
      sum = sum + (i.until - i.from);
    }
    out.push_back({{"robots", {pair.first.value, pair.second.value}},
                   {"seconds", sum.s()},
                   {"intervals", std::move(list)}});
  }
  return out;
}

}  // namespace muster::commsim
