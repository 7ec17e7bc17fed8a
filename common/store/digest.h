#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "common/store/record.h"

namespace muster::store {

/// Sequence numbers `first … last`, both included.
struct SeqRange {
  std::uint64_t first = 0, last = 0;
  auto operator<=>(const SeqRange&) const = default;
};

/// What somebody holds of one author's records of one class.
///
///     seq       1 2 3 4 5 6 7 8 9 10
///     complete  ────────┤              the author's newest version ≤ 5 of every key, or a newer one
///     beyond                ■   ■ ■    also seen: 7, 9, 10
///
/// One number alone would lose records: a lost seq looks just like one that was superseded before
/// anybody asked.
struct DigestEntry {
  Author author;
  RecordClass cls{};
  std::uint64_t complete = 0;
  std::vector<SeqRange> beyond;  ///< ascending, disjoint, all above `complete`
};

/// In an ExchangeEnd: the sender's own promise about one stream, and how many of its records it
/// sent in the numbered window.
struct EndEntry {
  Author author;
  RecordClass cls{};
  std::uint64_t complete = 0, sent = 0;
};

/// Closes what was sent in answer to one digest of one neighbour (the radio message is
/// mission::ExchangeEnd).
///
/// Who received, in envelopes `first_n` … the end's own, exactly `sent` records of every stream of
/// one (robot, class) may raise its `complete` of these streams to the sender's.
struct ExchangeEnd {
  RobotId receiver;
  std::uint64_t receiver_epoch = 0, digest_n = 0, first_n = 0;
  std::vector<EndEntry> entries;
};

/// A set of sequence numbers as ranges: small, as numbers mostly come in runs.
class SeqSet {
 public:
  SeqSet() = default;
  explicit SeqSet(const std::vector<SeqRange>& ranges);

  void insert(std::uint64_t seq) { insert(SeqRange{seq, seq}); }
  void insert(SeqRange range);
  bool contains(std::uint64_t seq) const;
  bool contains(SeqRange range) const;
  bool empty() const { return ranges_.empty(); }
  /// How far one gets from `n` without a gap: n, or the end of the range that holds n + 1. Forgets
  /// everything up to there.
  std::uint64_t advance(std::uint64_t n);
  std::vector<SeqRange> ranges() const;

 private:
  std::map<std::uint64_t, std::uint64_t> ranges_;  // first → last; disjoint and never adjacent
};

}  // namespace muster::store
