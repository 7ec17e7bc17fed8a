#pragma once

#include <cstdint>
#include <span>
#include <utility>
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
    std::vector<SeqRange> beyond;  ///< ascending, disjoint

    bool covers(std::uint64_t seq) const;
  };

  /// nullptr: it holds nothing of this stream.
  const Held* find(const StreamId& id) const;
  bool covers(const StreamId& id, std::uint64_t seq) const;
  /// It knows a newer start of the author, which voids this stream.
  bool voids(const StreamId& id) const;
  /// Ascending by id.
  const std::vector<Held>& held() const { return held_; }

 private:
  std::vector<Held> held_;
  std::vector<std::pair<RobotId, std::uint64_t>> newest_epoch_;  // ascending
};

}  // namespace muster::store
