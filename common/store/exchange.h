#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/core/random.h"
#include "common/store/peer_digest.h"
#include "common/store/record_store.h"

namespace muster::store {

struct ExchangeConfig {
  Duration contact = Duration::from_s(1);            ///< a beacon heard this recently is contact
  Duration digest_interval = Duration::from_s(0.3);  ///< digests are never closer than this
  Duration round_trip = Duration::from_s(
      0.2);  ///< a digest heard this long after a record was sent tells whether it arrived
  Duration holdoff_min =
      Duration::from_s(0.2);  ///< who forwards others' records first listens for a moment in
  Duration holdoff_max = Duration::from_s(0.6);  ///<   [min, max), so that one of many speaks
  Duration author_near =
      Duration::from_s(0.3);  ///< and this much longer when the author itself is in contact
  Duration silence = Duration::from_s(1);  ///< what somebody else sent is not repeated for so long,
                                           ///< unless a digest shows it was missed
  Duration retry = Duration::from_s(1);    ///< without any word back
  Duration heartbeat = Duration::from_s(3);  ///< in company, a digest at least so often: whoever
                                             ///< missed the last one has no way to say so
};

/// Decides what to send to whom, so that whoever can hear each other ends up holding the same
/// records.
///
///     R ── beacon + digest ──▶ S   what R holds
///     R ◀───── records ─────── S   what S holds and R lacks: value first, paced; all in reach hear it
///     R ◀─────── end ───────── S   "n₁ … n₂ held so many of each stream; now be as complete as I am"
///
/// An end is sent only when R cannot see by itself that nothing is missing (a gap in the numbers:
/// superseded, or lost?). It counts; it never assumes: R raises its `complete` only when it heard
/// every record of the window. Everything else (losses, repeats, cuts, others who sent the same)
/// shows in R's next digest and is answered again. So nothing here has to arrive for the scheme to
/// be right.
///
/// Per tick: feed on_beacon, on_record and on_end in the order heard, then call step, and put a
/// digest into the beacon when it is due. Not thread-safe. Pure: reads no clock.
class Exchange {
 public:
  /// `store` outlives this. `random` is this robot's own stream.
  Exchange(RecordStore& store, Random random, const ExchangeConfig& config = {});

  // ---- heard
  /// `digest_n` 0: this beacon carries no digest.
  void on_beacon(RobotId from, std::uint64_t epoch, std::uint64_t digest_n,
                 std::span<const DigestEntry> digest, SimTime now);
  /// A record in envelope `n` of `from`: merges it into the store.
  Merged on_record(RobotId from, std::uint64_t n, Record record, SimTime now);
  /// An exchange end in envelope `n` of `from`, whoever it is for.
  void on_end(RobotId from, std::uint64_t n, const ExchangeEnd& end);
  /// The neighbour is gone (else it is forgotten when no beacon was heard for `contact`).
  void neighbour_lost(RobotId id);

  // ---- to send
  struct Action {
    std::uint64_t n = 0;             ///< the envelope's number, taken from `next_n`
    const Record* record = nullptr;  ///< to be `read` and sent; good until the store changes
    std::optional<ExchangeEnd> end;  ///< or an end
  };
  using NextN = std::function<std::uint64_t()>;
  /// What to send now, in this order. `next_n` gives the number of the next envelope of this robot;
  /// every number taken has to be used for its action. Records stop at `byte_budget` (but at least
  /// one goes out when any is due); with a budget of 0 nothing is said at all.
  std::vector<Action> step(SimTime now, std::size_t byte_budget, const NextN& next_n);

  /// Should the next beacon carry the digest? Only when it may tell somebody something.
  bool digest_due(SimTime now) const;
  /// The digest goes into the beacon of now: its number.
  std::uint64_t digest_sent(SimTime now);

  // ---- contact
  std::vector<RobotId> contacts(SimTime now) const;
  bool in_contact(RobotId id, SimTime now) const;
  /// How many neighbours sent records lately (as long ago as contact lasts), or are new.
  std::size_t speakers(SimTime now) const;
  /// By its latest digest, `neighbour` lacks nothing that is held here, and has nothing that is
  /// not. Looks only at classes up to and with `last`, in the order of their value. False without
  /// contact or before its first digest.
  bool caught_up(RobotId neighbour, SimTime now, RecordClass last = RecordClass::kImage) const;
  /// By its latest digest, `neighbour` has this record or a newer one in its place.
  bool known_to(RobotId neighbour, const RecordHeader& header) const;

  struct Stats {
    std::uint64_t records_sent = 0, bytes_sent = 0, ends_sent = 0, digests_sent = 0;
    std::uint64_t records_heard = 0, duplicates_heard = 0;
  };
  const Stats& stats() const { return stats_; }

 private:
  using Group = std::pair<RobotId, RecordClass>;  // all epochs of one robot's class
  struct RecordId {
    StreamId stream;
    std::uint64_t seq = 0;
    auto operator<=>(const RecordId&) const = default;
  };
  struct HashRecordId {
    std::size_t operator()(const RecordId& id) const {
      std::uint64_t h = id.seq;
      for (const std::uint64_t part :
           {std::uint64_t{id.stream.robot.value}, static_cast<std::uint64_t>(id.stream.cls),
            std::uint64_t{id.stream.epoch}}) {
        h = (h ^ part) * 0x9E3779B97F4A7C15u;
        h ^= h >> 29;
      }
      return h;
    }
  };
  /// When a record was last on the air, as far as known here.
  struct Traffic {
    SimTime sent_at, heard_at;
    std::uint64_t sent_n = 0;  // 0: not sent here
    std::uint32_t attempts = 0;
    bool heard = false;
  };
  struct Peer {
    std::uint64_t epoch = 0;
    SimTime heard_at;
    SimTime spoke_at;            // when a record came from it; who is new is about to speak
    std::uint64_t digest_n = 0;  // 0: none heard yet
    SimTime digest_at;
    PeerDigest digest;
    std::optional<SimTime> forward_at;  // when others' records may be sent; nullopt: none is owed
    std::map<Group, SimTime> promised;  // when an end last covered it
    std::uint64_t settled_version = 0;  // of the store, when nothing was owed
  };
  /// What came in from one sender since it started, for counting.
  struct Heard {
    std::uint64_t epoch = 0;
    std::map<std::uint64_t, StreamId> by_n;
  };
  /// What one neighbour is owed of one group.
  struct Debt {
    Group group;
    std::vector<const Record*> due;  // to be sent now
    bool waiting = false;            // something is missing that is not to be sent now,
    bool held_back = false;          //   as somebody else may be about to send it
    bool gap = false;  // even with all of it the neighbour could not know that it is complete
    std::uint64_t first_n = 0;  // of what is on its way; 0: nothing
  };

  /// In the order of sending: value first.
  using Due = std::map<std::pair<RecordClass, RecordId>, const Record*>;

  static RecordId id_of(const RecordHeader& header);
  void set_epoch(Heard& heard, std::uint64_t epoch);
  void forget_silent(SimTime now);
  void prune(SimTime now);
  Duration holdoff();
  bool may_speak_for(const Peer& peer, RobotId author, SimTime now) const;
  std::vector<Debt> debts(Peer& peer, SimTime now);
  bool weigh_stream(const Peer& peer, const StreamId& id, const Stream& stream, SimTime now,
                    bool may_forward, Debt& debt) const;
  /// Of a record that the neighbour lacks: is it on its way, or due now?
  bool weigh(const Peer& peer, const Record& record, SimTime now, bool may_forward,
             Debt& debt) const;
  void send_records(const Due& due, SimTime now, std::size_t byte_budget, const NextN& next_n,
                    std::vector<Action>& out);
  bool is_on_its_way(Debt& debt, SimTime now) const;
  void send_end(RobotId id, std::vector<Debt>& owed, SimTime now, const NextN& next_n,
                std::vector<Action>& out);
  bool something_expected(SimTime now) const;

  RecordStore& store_;
  Random random_;
  ExchangeConfig config_;
  std::map<RobotId, Peer> peers_;
  std::map<RobotId, Heard> heard_;
  std::unordered_map<RecordId, Traffic, HashRecordId> traffic_;  // looked up for every record and
                                                                 // peer; order reaches nothing
  std::deque<std::pair<std::uint64_t, StreamId>> sent_;          // ascending by envelope number
  std::uint64_t digest_n_ = 0;
  SimTime digest_sent_at_;
  std::uint64_t digest_version_ = 0;  // of the store, when it was last sent
  bool newcomer_ = false;             // since the last digest
  bool answered_ = false;  // an end came in since the last digest: its sender wants to know
  bool repeated_ = false;  // a record came again: its sender seems not to have heard our digest
  SimTime pruned_at_;
  Stats stats_;
};

}  // namespace muster::store
