#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/store/digest.h"
#include "common/store/record.h"

namespace muster::store {

/// Is this class about how its author is doing now, so that a newer start of the author voids it
/// (DESIGN "Records")? Maps, areas, inspections, images and requests stay true whoever restarts.
constexpr bool voided_by_restart(RecordClass cls) {
  return cls == RecordClass::kPlan || cls == RecordClass::kMeeting || cls == RecordClass::kStatus;
}

/// One author's records of one class are one stream of sequence numbers. Ordered so that all epochs
/// of one (robot, class) are neighbours.
struct StreamId {
  RobotId robot;
  RecordClass cls{};
  std::uint64_t epoch = 0;
  auto operator<=>(const StreamId&) const = default;

  Author author() const { return {robot, epoch}; }
};

/// What is held of one stream.
struct Stream {
  std::uint64_t complete = 0;  ///< as in DigestEntry
  SeqSet seen;                 ///< above `complete`: held, or superseded since
  std::map<std::uint64_t, const Record*>
      held;                   ///< by seq: the records that are the newest of their key
  std::uint64_t version = 0;  ///< of the store, when `complete` or `seen` last changed

  bool covers(std::uint64_t seq) const { return seq <= complete || seen.contains(seq); }
  /// Who is complete up to `n` lacks nothing of this stream.
  bool adds_nothing_to(std::uint64_t n) const {
    return complete <= n && (held.empty() || held.rbegin()->first <= n);
  }
};

/// Where large bodies are that are not in memory (Journal).
class Bodies {
 public:
  virtual ~Bodies() = default;
  /// The bytes of a record that it said it has. Throws Failure when they cannot be read.
  virtual void read(const RecordHeader& header, Bytes& into) const = 0;
};

/// Everything a robot knows: of every (robot, class, key) the newest version, in whatever order it
/// arrived. Merging is commutative, associative and idempotent, so stores that have heard the same
/// records are equal.
///
/// Not thread-safe. Pure: reads no clock.
class RecordStore {
 public:
  /// Of two records of one key: does `fresh` take the place of `held`?
  using Supersedes = bool (*)(const RecordHeader& fresh, const RecordHeader& held);
  static bool is_newer(const RecordHeader& fresh, const RecordHeader& held) {
    return fresh.version() > held.version();
  }

  /// Any other rule than `is_newer` loses records: tests break it, to see that they would notice.
  RecordStore(RobotId self, std::uint64_t epoch, Supersedes supersedes = is_newer);

  RobotId self() const { return self_; }
  /// Of own records written from now on. Rises above any larger epoch of this robot that is heard:
  /// then everything that a restart voids (plan, meetings, status) has to be published again.
  std::uint64_t epoch() const { return epoch_; }

  /// The header for the next own record; each must be inserted before the next one of its class is
  /// asked for.
  RecordHeader next_header(RecordClass cls, std::uint64_t key, SimTime now) const;
  /// A key that no earlier or later start of this robot uses: for things that are counted rather
  /// than named.
  std::uint64_t new_key(RecordClass cls);
  /// `record.header` is the last one that `next_header` gave for its class.
  void insert_own(Record record);

  enum class Merged {
    kNew,        ///< the newest of its key: held now
    kOlder,      ///< superseded by what is held, or voided by a newer epoch
    kDuplicate,  ///< held already
    kRefused,    ///< not a record: unknown class or seq 0
  };
  Merged merge(Record record);

  /// The newest version, or nullptr. Pointers stay good until their record is superseded or voided.
  /// `bytes` may be empty once the record is kept elsewhere: then only `read` has them.
  const Record* find(RobotId author, RecordClass cls, std::uint64_t key) const;
  /// A held record with its bytes, wherever they are; `buffer` takes those that are not in memory.
  /// Throws Failure when they cannot be read.
  RecordView read(const Record& held, Bytes& buffer) const;
  /// How many bytes these are.
  std::size_t size_of(const Record& held) const { return at(held.header).size; }
  /// From now on `bodies`, which outlives this store's use, has the bytes of a held record: large
  /// ones of results leave the memory. Changes nothing else.
  void kept(const Record& held, const Bodies& bodies);
  /// All of a class, by (author, key).
  std::vector<const Record*> all(RecordClass cls) const;
  /// What became newest since `cursor` (0 at first), each record once, in the order of arrival;
  /// moves the cursor.
  std::vector<const Record*> changes(RecordClass cls, std::uint64_t& cursor) const;
  /// Counts the records of a class that were voided and not replaced; `changes` cannot tell of
  /// those.
  std::uint64_t voided(RecordClass cls) const { return voided_[index(cls)]; }
  std::size_t size() const { return size_; }

  /// By (author, class). Good until the store changes.
  const std::vector<DigestEntry>& digest() const;
  /// Takes over a promise that holds for us too (see ExchangeEnd). Ignored for own and for voided
  /// streams.
  void raise(Author author, RecordClass cls, std::uint64_t complete);
  /// What a journal kept of a stream, after its records were merged.
  void resume(const StreamId& id, std::uint64_t complete, std::span<const SeqRange> seen);
  /// Is what somebody tells of a stream seen or promised here as well, or voided?
  bool covers(const StreamId& id, std::uint64_t complete, std::span<const SeqRange> beyond) const;

  const std::map<StreamId, Stream>& streams() const { return streams_; }
  /// Grows whenever the digest changes.
  std::uint64_t version() const { return version_; }
  /// Of the records held, whatever the order of their arrival.
  std::uint64_t content_hash() const { return content_hash_; }

 private:
  struct Name {
    RobotId robot;
    std::uint64_t key = 0;
    auto operator<=>(const Name&) const = default;
  };
  struct Held {
    Record record;
    std::uint64_t hash = 0;
    std::uint64_t change = 0;
    std::size_t size = 0;               // of the record's bytes
    const Bodies* elsewhere = nullptr;  // who has them; nullptr: they are in the record
  };
  struct ClassRecords {
    std::map<Name, std::unique_ptr<Held>> by_name;
    std::map<std::uint64_t, const Held*> by_change;
  };

  static std::size_t index(RecordClass cls) { return static_cast<std::size_t>(cls) - 1; }
  ClassRecords& of(RecordClass cls) { return classes_[index(cls)]; }
  const ClassRecords& of(RecordClass cls) const { return classes_[index(cls)]; }
  const Held& at(const RecordHeader& header) const {
    return *of(header.cls).by_name.at({header.author.robot, header.key});
  }
  bool is_voided(Author author, RecordClass cls) const;
  void hear_epoch(Author author);
  Merged put(Record record);
  void forget(const Held& held);

  RobotId self_;
  std::uint64_t epoch_;
  Supersedes supersedes_;
  std::array<ClassRecords, kRecordClasses> classes_;
  std::array<std::uint64_t, kRecordClasses> keys_given_{};
  std::array<std::uint64_t, kRecordClasses> voided_{};
  std::map<StreamId, Stream> streams_;
  std::map<RobotId, std::uint64_t> newest_epoch_;  // of which a record was seen
  std::size_t size_ = 0;
  std::uint64_t last_change_ = 0;
  std::uint64_t version_ = 1;
  std::uint64_t content_hash_ = 0;
  mutable std::vector<DigestEntry> digest_;
  mutable std::uint64_t digest_version_ = 0;
};

using Merged = RecordStore::Merged;

}  // namespace muster::store
