#include "common/store/peer_digest.h"

#include <algorithm>

namespace muster::store {
namespace {

/// Our own digests are in order; what comes over the radio need not be.
bool in_order(const std::vector<SeqRange>& ranges) {
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (ranges[i].first > ranges[i].last) return false;
    if (i > 0 && ranges[i].first <= ranges[i - 1].last) return false;
  }
  return true;
}

}  // namespace

PeerDigest::PeerDigest(std::span<const DigestEntry> entries) {
  held_.reserve(entries.size());
  for (const DigestEntry& e : entries) {
    held_.push_back({{e.author.robot, e.cls, e.author.epoch},
                     e.complete,
                     in_order(e.beyond) ? e.beyond : SeqSet(e.beyond).ranges()});
  }
  std::ranges::sort(held_, {}, &Held::id);
  for (const Held& h : held_) {
    if (newest_epoch_.empty() || newest_epoch_.back().first != h.id.robot) {
      newest_epoch_.emplace_back(h.id.robot, h.id.epoch);
    } else {
      newest_epoch_.back().second = std::max(newest_epoch_.back().second, h.id.epoch);
    }
  }
}

bool PeerDigest::Held::covers(std::uint64_t seq) const {
  if (seq <= complete) return true;
  const auto it = std::ranges::lower_bound(beyond, seq, {}, &SeqRange::last);
  return it != beyond.end() && it->first <= seq;
}

const PeerDigest::Held* PeerDigest::find(const StreamId& id) const {
  const auto it = std::ranges::lower_bound(held_, id, {}, &Held::id);
  return it != held_.end() && it->id == id ? &*it : nullptr;
}

bool PeerDigest::covers(const StreamId& id, std::uint64_t seq) const {
  const Held* held = find(id);
  return held != nullptr && held->covers(seq);
}

bool PeerDigest::voids(const StreamId& id) const {
  if (!voided_by_restart(id.cls)) return false;
  const auto newest = std::ranges::lower_bound(
      newest_epoch_, id.robot, {}, [](const auto& robot_epoch) { return robot_epoch.first; });
  return newest != newest_epoch_.end() && newest->first == id.robot && newest->second > id.epoch;
}

}  // namespace muster::store
