#include "common/store/digest.h"

#include <algorithm>
#include <iterator>

namespace muster::store {

SeqSet::SeqSet(const std::vector<SeqRange>& ranges) {
  for (const SeqRange& range : ranges) insert(range);
}

void SeqSet::insert(SeqRange range) {
  if (range.first > range.last) return;
  auto it = ranges_.upper_bound(range.first);
  // Joins the range before when that one reaches or touches this one, then everything this one
  // reaches or touches.
  if (it != ranges_.begin()) {
    const auto before = std::prev(it);
    if (before->second >= range.last) return;
    if (before->second + 1 >= range.first) {
      range.first = before->first;
      it = ranges_.erase(before);
    }
  }
  while (it != ranges_.end() && it->first - 1 <= range.last) {
    range.last = std::max(range.last, it->second);
    it = ranges_.erase(it);
  }
  ranges_.emplace_hint(it, range.first, range.last);
}

bool SeqSet::contains(std::uint64_t seq) const { return contains(SeqRange{seq, seq}); }

bool SeqSet::contains(SeqRange range) const {
  const auto it = ranges_.upper_bound(range.first);
  return it != ranges_.begin() && std::prev(it)->second >= range.last;
}

std::uint64_t SeqSet::advance(std::uint64_t n) {
  while (!ranges_.empty() && ranges_.begin()->first <= n + 1) {
    n = std::max(n, ranges_.begin()->second);
    ranges_.erase(ranges_.begin());
  }
  // A range that begins below n + 1 ends at or below the new n, so nothing is left that reaches n.
  return n;
}

std::vector<SeqRange> SeqSet::ranges() const {
  std::vector<SeqRange> out;
  out.reserve(ranges_.size());
  for (const auto& [first, last] : ranges_) out.push_back({first, last});
  return out;
}

}  // namespace muster::store
