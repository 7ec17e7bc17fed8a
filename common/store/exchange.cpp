#include "common/store/exchange.h"

#include <algorithm>
#include <iterator>

namespace muster::store {
namespace {

constexpr std::size_t kEnvelopeBytes =
    28;  // encapsulation and envelope around a record's own bytes
constexpr std::size_t kRemembered =
    20'000;  // envelopes remembered per direction and sender, far more than any window
const Duration kTrafficMemory = Duration::from_s(10);
const Duration kLongestBackoff = Duration::from_s(2);

/// A record that a fresh digest shows as missed was lost, not late; but who is hard to reach is not
/// worth a flood.
Duration backoff(std::uint32_t attempts, Duration first) {
  Duration wait = first;
  for (std::uint32_t i = 1; i < attempts && wait < kLongestBackoff; ++i) wait = wait * 2;
  return std::min(wait, kLongestBackoff);
}

}  // namespace

Exchange::RecordId Exchange::id_of(const RecordHeader& h) {
  return {{h.author.robot, h.cls, h.author.epoch}, h.seq};
}

Exchange::Exchange(RecordStore& store, Random random, const ExchangeConfig& config)
    : store_(store), random_(random), config_(config) {}

void Exchange::set_epoch(Heard& heard, std::uint64_t epoch) {
  // Envelope numbers begin anew with every start of a process: what was counted of the one before
  // must not count for this one.
  if (heard.epoch != epoch) heard.by_n.clear();
  heard.epoch = epoch;
}

void Exchange::on_beacon(RobotId from, std::uint64_t epoch, std::uint64_t digest_n,
                         std::span<const DigestEntry> digest, SimTime now) {
  if (from == store_.self()) return;
  auto [it, fresh] = peers_.try_emplace(from);
  if (!fresh && epoch < it->second.epoch) return;  // late word of a process that is no more
  if (!fresh && (epoch > it->second.epoch || now - it->second.heard_at > config_.contact)) {
    it->second = {};
    fresh = true;
  }
  newcomer_ |= fresh;
  if (fresh) it->second.spoke_at = now;
  Peer& peer = it->second;
  peer.epoch = epoch;
  peer.heard_at = now;
  set_epoch(heard_[from], epoch);
  if (digest_n <= peer.digest_n) return;
  peer.digest_n = digest_n;
  peer.digest_at = now;
  peer.digest = PeerDigest(digest);
  peer.settled_version = 0;
}

Merged Exchange::on_record(RobotId from, std::uint64_t n, Record record, SimTime now) {
  const RecordHeader& h = record.header;
  const RecordId id = id_of(h);
  const Merged merged = store_.merge(std::move(record));
  if (merged == Merged::kRefused) return merged;
  if (const auto peer = peers_.find(from); peer != peers_.end()) peer->second.spoke_at = now;
  auto& by_n = heard_[from].by_n;
  by_n.emplace(n, id.stream);
  if (by_n.size() > kRemembered) by_n.erase(by_n.begin());
  ++stats_.records_heard;
  Traffic& traffic = traffic_[id];
  traffic.heard = true;
  traffic.heard_at = now;
  if (merged == Merged::kNew) return merged;
  ++stats_.duplicates_heard;
  repeated_ = true;
  for (auto& [other, peer] : peers_) {
    // Somebody is serving this neighbour with what we could have sent: leave it to them.
    if (other == from || !peer.forward_at || peer.digest.covers(id.stream, id.seq)) continue;
    peer.forward_at = std::max(*peer.forward_at, now + holdoff());
  }
  return merged;
}

void Exchange::on_end(RobotId from, std::uint64_t n, const ExchangeEnd& end) {
  if (end.receiver != store_.self() || end.receiver_epoch != store_.epoch()) return;
  if (end.first_n > n) return;  // no window at all
  answered_ = true;
  std::uint64_t sender_epoch = 0;  // every end names at least one of its sender's own streams
  std::map<StreamId, std::uint64_t> received;
  for (const EndEntry& e : end.entries) {
    if (e.author.robot == from) sender_epoch = std::max(sender_epoch, e.author.epoch);
    received[{e.author.robot, e.cls, e.author.epoch}] = 0;
  }
  Heard& heard = heard_[from];
  set_epoch(heard, sender_epoch);
  const auto until = heard.by_n.lower_bound(n);
  for (auto it = heard.by_n.lower_bound(end.first_n); it != heard.by_n.end() && it != until; ++it) {
    const auto stream = received.find(it->second);
    if (stream != received.end()) ++stream->second;
  }
  // A key's newest version may be of another epoch, so the epochs of one (robot, class) are
  // complete together or not at all.
  std::set<Group> short_of;
  for (const EndEntry& e : end.entries) {
    if (received[{e.author.robot, e.cls, e.author.epoch}] != e.sent) {
      short_of.insert({e.author.robot, e.cls});
    }
  }
  for (const EndEntry& e : end.entries) {
    if (!short_of.contains({e.author.robot, e.cls})) store_.raise(e.author, e.cls, e.complete);
  }
}

void Exchange::neighbour_lost(RobotId id) {
  peers_.erase(id);
  heard_.erase(id);
}

void Exchange::forget_silent(SimTime now) {
  for (auto it = peers_.begin(); it != peers_.end();) {
    if (now - it->second.heard_at > config_.contact) {
      heard_.erase(it->first);
      it = peers_.erase(it);
    } else {
      ++it;
    }
  }
}

void Exchange::prune(SimTime now) {
  if (now - pruned_at_ < kTrafficMemory) return;
  pruned_at_ = now;
  std::erase_if(traffic_, [&](const auto& entry) {
    const Traffic& t = entry.second;
    return now - std::max(t.sent_at, t.heard_at) > kTrafficMemory;
  });
  while (sent_.size() > kRemembered) sent_.pop_front();
}

Duration Exchange::holdoff() {
  return Duration::from_s(random_.uniform(config_.holdoff_min.s(), config_.holdoff_max.s()));
}

bool Exchange::may_speak_for(const Peer& peer, RobotId author, SimTime now) const {
  // With nobody else to listen to, waiting would gain nothing.
  if (author == store_.self() || peers_.size() == 1) return true;
  if (!peer.forward_at) return false;
  const Duration more = peers_.contains(author) ? config_.author_near : Duration{};
  return now >= *peer.forward_at + more;
}

bool Exchange::weigh(const Peer& peer, const Record& record, SimTime now, bool may_forward,
                     Debt& debt) const {
  const auto it = traffic_.find(id_of(record.header));
  if (it != traffic_.end()) {
    const Traffic& t = it->second;
    if (t.sent_n != 0) {
      const bool answered = peer.digest_at >= t.sent_at + config_.round_trip;
      if (!answered && now < t.sent_at + config_.retry) {
        debt.first_n = debt.first_n == 0 ? t.sent_n : std::min(debt.first_n, t.sent_n);
        return true;
      }
      if (answered && now < t.sent_at + backoff(t.attempts, config_.round_trip)) {
        debt.waiting = true;
        return false;
      }
    }
    const bool hushed = t.heard && peer.digest_at < t.heard_at + config_.round_trip &&
                        now < t.heard_at + config_.silence;
    if (hushed) {
      debt.waiting = true;
      return false;
    }
  }
  if (may_forward) {
    debt.due.push_back(&record);
  } else {
    debt.waiting = debt.held_back = true;
  }
  return may_forward;
}

bool Exchange::weigh_stream(const Peer& peer, const StreamId& id, const Stream& stream, SimTime now,
                            bool may_forward, Debt& debt) const {
  const PeerDigest::Held* held = peer.digest.find(id);
  const std::uint64_t complete = held == nullptr ? 0 : held->complete;
  if (stream.adds_nothing_to(complete)) return false;
  bool owed = false;
  std::vector<SeqRange> arriving;
  for (auto r = stream.held.upper_bound(complete); r != stream.held.end(); ++r) {
    // Held back and waiting: nothing is due and no end is sent, whatever else is owed. In a crowd
    // this is most of all records.
    if (!may_forward && debt.held_back && debt.waiting) return true;
    if (held != nullptr && held->covers(r->first)) continue;
    if (weigh(peer, *r->second, now, may_forward, debt)) arriving.push_back({r->first, r->first});
    owed = true;
  }
  if (stream.complete <= complete) return owed;
  // What is waiting puts off the end anyway, so only then it matters whether there is a gap.
  if (!debt.waiting && !debt.gap) {
    SeqSet then(arriving);
    if (held != nullptr) {
      for (const SeqRange& range : held->beyond) then.insert(range);
    }
    debt.gap = then.advance(complete) < stream.complete;
  }
  return true;
}

std::vector<Exchange::Debt> Exchange::debts(Peer& peer, SimTime now) {
  std::vector<Debt> out;
  bool others_owed = false;
  const auto& streams = store_.streams();
  const auto& known = peer.digest.held();
  auto k = known.begin();
  for (auto it = streams.begin(); it != streams.end();) {
    const auto first = it;
    const Group group{first->first.robot, first->first.cls};
    bool quiet = true;  // nearly always: found out by walking both lists once
    for (; it != streams.end() && Group{it->first.robot, it->first.cls} == group; ++it) {
      while (k != known.end() && k->id < it->first) ++k;
      const bool found = k != known.end() && k->id == it->first;
      quiet &= it->second.adds_nothing_to(found ? k->complete : 0);
    }
    if (quiet) continue;
    Debt debt;
    debt.group = group;
    const bool may_forward = may_speak_for(peer, group.first, now);
    bool owed = false;
    for (auto s = first; s != it; ++s) {
      if (peer.digest.voids(s->first)) continue;
      owed |= weigh_stream(peer, s->first, s->second, now, may_forward, debt);
    }
    if (!owed) continue;
    const bool actionable = !debt.due.empty() || debt.held_back || (debt.gap && !debt.waiting);
    if (group.first != store_.self() && actionable) others_owed = true;
    out.push_back(std::move(debt));
  }
  if (!others_owed) {
    peer.forward_at.reset();
  } else if (!peer.forward_at) {
    peer.forward_at = now + holdoff();
  }
  return out;
}

std::vector<Exchange::Action> Exchange::step(SimTime now, std::size_t byte_budget,
                                             const NextN& next_n) {
  forget_silent(now);
  prune(now);
  if (byte_budget == 0) return {};
  std::vector<Action> out;
  Due due;
  std::vector<std::pair<RobotId, std::vector<Debt>>> owing;
  for (auto& [id, peer] : peers_) {
    if (peer.digest_n == 0 || peer.settled_version == store_.version()) continue;
    std::vector<Debt> owed = debts(peer, now);
    if (owed.empty()) {
      peer.settled_version = store_.version();
      continue;
    }
    for (const Debt& debt : owed) {
      for (const Record* record : debt.due) {
        due.emplace(std::pair(record->header.cls, id_of(record->header)), record);
      }
    }
    owing.emplace_back(id, std::move(owed));
  }
  send_records(due, now, byte_budget, next_n, out);
  for (auto& [id, owed] : owing) send_end(id, owed, now, next_n, out);
  return out;
}

void Exchange::send_records(const Due& due, SimTime now, std::size_t byte_budget,
                            const NextN& next_n, std::vector<Action>& out) {
  std::size_t bytes = 0;
  for (const auto& [order, record] : due) {
    const std::size_t size = store_.size_of(*record) + kEnvelopeBytes;
    bytes += size;
    if (bytes > byte_budget && !out.empty()) break;
    const std::uint64_t n = next_n();
    Traffic& traffic = traffic_[order.second];
    const bool again = traffic.sent_n != 0 && now - traffic.sent_at < kTrafficMemory;
    traffic.attempts = again ? traffic.attempts + 1 : 1;
    traffic.sent_at = now;
    traffic.sent_n = n;
    sent_.emplace_back(n, order.second.stream);
    ++stats_.records_sent;
    stats_.bytes_sent += size;
    out.push_back({n, record, std::nullopt});
  }
}

bool Exchange::is_on_its_way(Debt& debt, SimTime now) const {
  for (const Record* record : debt.due) {
    const auto it = traffic_.find(id_of(record->header));
    if (it == traffic_.end() || it->second.sent_n == 0 || it->second.sent_at != now) return false;
    debt.first_n =
        debt.first_n == 0 ? it->second.sent_n : std::min(debt.first_n, it->second.sent_n);
  }
  return !debt.waiting;
}

void Exchange::send_end(RobotId id, std::vector<Debt>& owed, SimTime now, const NextN& next_n,
                        std::vector<Action>& out) {
  Peer& peer = peers_.at(id);
  ExchangeEnd end{id, peer.epoch, peer.digest_n, 0, {}};
  bool own_named = false;
  for (Debt& debt : owed) {
    if (!debt.gap || !is_on_its_way(debt, now)) continue;
    if (!may_speak_for(peer, debt.group.first, now)) continue;
    const auto before = peer.promised.find(debt.group);
    const bool promised = before != peer.promised.end() &&
                          peer.digest_at < before->second + config_.round_trip &&
                          now < before->second + config_.retry;
    if (promised) continue;
    peer.promised[debt.group] = now;
    if (debt.first_n != 0 && (end.first_n == 0 || debt.first_n < end.first_n)) {
      end.first_n = debt.first_n;
    }
    const auto& [robot, cls] = debt.group;
    const auto& streams = store_.streams();
    for (auto s = streams.lower_bound({robot, cls, 0}); s != streams.end(); ++s) {
      const StreamId& stream = s->first;
      if (Group{stream.robot, stream.cls} != debt.group) break;
      if (peer.digest.voids(stream)) continue;
      end.entries.push_back({stream.author(), stream.cls, s->second.complete, 0});
      own_named |= stream.author() == Author{store_.self(), store_.epoch()};
    }
  }
  if (end.entries.empty()) return;
  // The receiver learns from it which start of ours is counting (a promise of 0 binds nobody).
  if (!own_named) {
    end.entries.push_back({{store_.self(), store_.epoch()}, RecordClass::kStatus, 0, 0});
  }
  const std::uint64_t n = next_n();
  if (end.first_n == 0) end.first_n = n;
  std::map<StreamId, std::uint64_t> sent;
  for (auto it = sent_.rbegin(); it != sent_.rend() && it->first >= end.first_n; ++it) {
    ++sent[it->second];
  }
  for (EndEntry& e : end.entries) {
    const auto it = sent.find({e.author.robot, e.cls, e.author.epoch});
    if (it != sent.end()) e.sent = it->second;
  }
  ++stats_.ends_sent;
  out.push_back({n, nullptr, std::move(end)});
}

bool Exchange::something_expected(SimTime now) const {
  return std::ranges::any_of(peers_, [&](const auto& entry) {
    const Peer& peer = entry.second;
    if (now - peer.heard_at > config_.contact) return false;
    return peer.digest_n == 0 ||
           !std::ranges::all_of(peer.digest.held(), [&](const PeerDigest::Held& h) {
             return store_.covers(h.id, h.complete, h.beyond);
           });
  });
}

bool Exchange::digest_due(SimTime now) const {
  if (contacts(now).empty()) return false;
  if (digest_n_ == 0) return true;
  const Duration since = now - digest_sent_at_;
  if (since < config_.digest_interval) return false;
  if (newcomer_ || answered_ || digest_version_ != store_.version()) return true;
  if (since >= config_.heartbeat) return true;
  return since >= config_.retry && (repeated_ || something_expected(now));
}

std::uint64_t Exchange::digest_sent(SimTime now) {
  digest_sent_at_ = now;
  digest_version_ = store_.version();
  newcomer_ = answered_ = repeated_ = false;
  ++stats_.digests_sent;
  return ++digest_n_;
}

std::vector<RobotId> Exchange::contacts(SimTime now) const {
  std::vector<RobotId> out;
  for (const auto& [id, peer] : peers_) {
    if (now - peer.heard_at <= config_.contact) out.push_back(id);
  }
  return out;
}

bool Exchange::in_contact(RobotId id, SimTime now) const {
  const auto it = peers_.find(id);
  return it != peers_.end() && now - it->second.heard_at <= config_.contact;
}

std::size_t Exchange::speakers(SimTime now) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      peers_, [&](const auto& entry) { return now - entry.second.spoke_at <= config_.contact; }));
}

bool Exchange::caught_up(RobotId neighbour, SimTime now, RecordClass last) const {
  if (!in_contact(neighbour, now)) return false;
  const Peer& peer = peers_.at(neighbour);
  if (peer.digest_n == 0) return false;
  if (peer.settled_version != store_.version()) {
    for (const auto& [id, stream] : store_.streams()) {
      if (id.cls > last || peer.digest.voids(id)) continue;
      const PeerDigest::Held* held = peer.digest.find(id);
      auto missing = stream.held.upper_bound(held == nullptr ? 0 : held->complete);
      for (; missing != stream.held.end(); ++missing) {
        if (held == nullptr || !held->covers(missing->first)) return false;
      }
    }
  }
  return std::ranges::all_of(peer.digest.held(), [&](const PeerDigest::Held& h) {
    return h.id.cls > last || store_.covers(h.id, h.complete, h.beyond);
  });
}

bool Exchange::known_to(RobotId neighbour, const RecordHeader& header) const {
  const auto it = peers_.find(neighbour);
  if (it == peers_.end()) return false;
  const StreamId id{header.author.robot, header.cls, header.author.epoch};
  return it->second.digest.covers(id, header.seq) || it->second.digest.voids(id);
}

}  // namespace muster::store
