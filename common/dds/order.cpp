#include "common/dds/order.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "common/dds/convert.h"

namespace muster::dds {

void sort_messages(std::vector<mission::Message>& messages) {
  using Rank = std::tuple<RobotId, std::uint64_t, std::size_t>;
  std::vector<Rank> ranks;
  ranks.reserve(messages.size());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const mission::Envelope envelope = peek_envelope(messages[i].cdr);
    ranks.emplace_back(envelope.src, envelope.n, i);
  }
  if (std::is_sorted(ranks.begin(), ranks.end())) return;
  std::sort(ranks.begin(), ranks.end());
  std::vector<mission::Message> sorted;
  sorted.reserve(messages.size());
  for (const Rank& rank : ranks) sorted.push_back(std::move(messages[std::get<2>(rank)]));
  messages = std::move(sorted);
}

}  // namespace muster::dds
