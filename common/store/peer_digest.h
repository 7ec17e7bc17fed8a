#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/store/digest.h"
#include "common/store/record_store.h"

namespace muster::store {

/// What a neighbour holds, by the latest digest heard from it.
class PeerDigest {
 public:
  PeerDigest() = default;
  explicit PeerDigest(std::span<const DigestEntry> entries);

  struct Held {
    StreamId id;
    std::uint64_t complete = 0;
    SeqSet beyond;

    bool covers(std::uint64_t seq) const { return seq <= complete || beyond.contains(seq); }
  };

  /// nullptr: it holds nothing of this stream.
  const Held* find(const StreamId& id) const;
  bool covers(const StreamId& id, std::uint64_t seq) const;
  /// It knows a newer start of the author, which voids this stream.
  bool voids(const StreamId& id) const;
  const std::vector<DigestEntry>& entries() const { return entries_; }

 private:
  std::vector<DigestEntry> entries_;
  std::vector<Held> held_;  // ascending by id
  std::map<RobotId, std::uint64_t> newest_epoch_;
};

}  // namespace muster::store
