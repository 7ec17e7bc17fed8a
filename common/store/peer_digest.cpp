#include "common/store/peer_digest.h"

#include <algorithm>

namespace muster::store {

PeerDigest::PeerDigest(std::span<const DigestEntry> entries)
    : entries_(entries.begin(), entries.end()) {
  held_.reserve(entries.size());
  for (const DigestEntry& entry : entries) {
    held_.push_back({{entry.author.robot, entry.cls, entry.author.epoch},
                     entry.complete,
                     SeqSet(entry.beyond)});
    std::uint64_t& newest = newest_epoch_[entry.author.robot];
    newest = std::max(newest, entry.author.epoch);
  }
  std::ranges::sort(held_, {}, &Held::id);
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
  const auto newest = newest_epoch_.find(id.robot);
  return newest != newest_epoch_.end() && newest->second > id.epoch;
}

}  // namespace muster::store
