#include "common/store/record_store.h"

#include <algorithm>
#include <limits>

#include "common/core/error.h"
#include "common/core/hash.h"

namespace muster::store {
namespace {

StreamId stream_id(const RecordHeader& header) {
  return {header.author.robot, header.cls, header.author.epoch};
}

bool is_class(RecordClass cls) {
  const auto value = static_cast<std::uint32_t>(cls);
  return value >= 1 && value <= kRecordClasses;
}

/// Bodies that nobody looks at until they are sent on, and too many to hold: a feature's image is
/// 200 kB.
bool is_better_on_disk(const Record& record) {
  constexpr std::size_t kLarge_bytes = 1024;
  const RecordClass cls = record.header.cls;
  return record.bytes.size() > kLarge_bytes &&
         (cls == RecordClass::kInspection || cls == RecordClass::kImage);
}

std::uint64_t hash_record(const Record& record) {
  const RecordHeader& h = record.header;
  return Hasher()
      .add(h.author.robot.value)
      .add(h.author.epoch)
      .add(h.cls)
      .add(h.key)
      .add(h.seq)
      .add_bytes(record.bytes)
      .value();
}

}  // namespace

RecordStore::RecordStore(RobotId self, std::uint64_t epoch, Supersedes supersedes)
    : self_(self), epoch_(epoch), supersedes_(supersedes) {}

RecordHeader RecordStore::next_header(RecordClass cls, std::uint64_t key, SimTime now) const {
  MUSTER_CHECK(is_class(cls));
  const auto it = streams_.find({self_, cls, epoch_});
  const std::uint64_t last = it == streams_.end() ? 0 : it->second.complete;
  return {{self_, epoch_}, cls, key, last + 1, now, {}};
}

std::uint64_t RecordStore::new_key(RecordClass cls) {
  // Epochs are milliseconds (41 bits) or small counts: a million keys per start fit behind them.
  return (epoch_ << 20) + ++keys_given_[index(cls)];
}

void RecordStore::insert_own(Record record) {
  const RecordHeader expected = next_header(record.header.cls, record.header.key, {});
  MUSTER_CHECK(record.header.author == expected.author && record.header.seq == expected.seq);
  const StreamId id = stream_id(record.header);
  hear_epoch(record.header.author);
  const std::uint64_t seq = record.header.seq;
  put(std::move(record));
  Stream& stream = streams_[id];
  stream.complete = stream.seen.advance(seq);
  stream.version = version_;
}

RecordStore::Merged RecordStore::merge(Record record) {
  const RecordHeader& h = record.header;
  if (!is_class(h.cls) || h.seq == 0) return Merged::kRefused;
  if (h.author.robot == self_ && h.author.epoch >= epoch_) {
    const auto own = streams_.find(stream_id(h));
    const bool mine =
        own != streams_.end() && h.author.epoch == epoch_ && own->second.covers(h.seq);
    // Somebody wrote as us later than we did: an earlier start with a clock that ran ahead. Never
    // reuse its numbers.
    if (!mine && h.author.epoch < std::numeric_limits<std::uint64_t>::max()) {
      epoch_ = h.author.epoch + 1;
      keys_given_ = {};
    }
  }
  if (is_voided(h.author, h.cls)) return Merged::kOlder;
  hear_epoch(h.author);
  const StreamId id = stream_id(h);
  const std::uint64_t seq = h.seq;
  const Merged merged = put(std::move(record));
  Stream& stream = streams_[id];
  if (!stream.covers(seq)) {
    stream.seen.insert(seq);
    // Having seen every number up to n is having the newest version ≤ n of every key, without
    // anybody's promise.
    stream.complete = stream.seen.advance(stream.complete);
    stream.version = ++version_;
  }
  return merged;
}

RecordStore::Merged RecordStore::put(Record record) {
  const RecordHeader& h = record.header;
  ClassRecords& records = of(h.cls);
  const auto [it, inserted] = records.by_name.try_emplace({h.author.robot, h.key});
  if (!inserted) {
    const RecordHeader& held = it->second->record.header;
    if (held.version() == h.version()) return Merged::kDuplicate;
    if (!supersedes_(h, held)) return Merged::kOlder;
    forget(*it->second);
  }
  auto fresh = std::make_unique<Held>();
  fresh->hash = hash_record(record);
  fresh->change = ++last_change_;
  fresh->size = record.bytes.size();
  fresh->record = std::move(record);
  content_hash_ += fresh->hash;
  ++size_;
  ++version_;
  records.by_change.emplace(fresh->change, fresh.get());
  streams_[stream_id(fresh->record.header)].held.emplace(fresh->record.header.seq, &fresh->record);
  it->second = std::move(fresh);
  return Merged::kNew;
}

void RecordStore::kept(const Record& record, const Bodies& bodies) {
  if (!is_better_on_disk(record)) return;
  Held& held = *of(record.header.cls).by_name.at({record.header.author.robot, record.header.key});
  held.elsewhere = &bodies;
  Bytes().swap(held.record.bytes);  // gives the memory back; `= {}` keeps it
}

RecordView RecordStore::read(const Record& record, Bytes& buffer) const {
  const Bodies* elsewhere = at(record.header).elsewhere;
  if (elsewhere == nullptr) return record;
  elsewhere->read(record.header, buffer);
  return {record.header, buffer};
}

void RecordStore::forget(const Held& held) {
  content_hash_ -= held.hash;
  --size_;
  of(held.record.header.cls).by_change.erase(held.change);
  streams_[stream_id(held.record.header)].held.erase(held.record.header.seq);
}

bool RecordStore::is_voided(Author author, RecordClass cls) const {
  if (!voided_by_restart(cls)) return false;
  const auto newest = newest_epoch_.find(author.robot);
  return newest != newest_epoch_.end() && author.epoch < newest->second;
}

void RecordStore::hear_epoch(Author author) {
  std::uint64_t& newest = newest_epoch_[author.robot];
  if (author.epoch <= newest) return;
  newest = author.epoch;
  auto it = streams_.lower_bound({author.robot, RecordClass{}, 0});
  while (it != streams_.end() && it->first.robot == author.robot) {
    if (!is_voided(it->first.author(), it->first.cls)) {
      ++it;
      continue;
    }
    ClassRecords& records = of(it->first.cls);
    const auto held = std::move(it->second.held);
    for (const auto& [seq, record] : held) {
      const auto gone = records.by_name.find({author.robot, record->header.key});
      content_hash_ -= gone->second->hash;
      records.by_change.erase(gone->second->change);
      records.by_name.erase(gone);
      --size_;
      ++voided_[index(it->first.cls)];
    }
    it = streams_.erase(it);
    ++version_;
  }
}

const Record* RecordStore::find(RobotId author, RecordClass cls, std::uint64_t key) const {
  const auto& by_name = of(cls).by_name;
  const auto it = by_name.find({author, key});
  return it == by_name.end() ? nullptr : &it->second->record;
}

std::vector<const Record*> RecordStore::all(RecordClass cls) const {
  std::vector<const Record*> out;
  out.reserve(of(cls).by_name.size());
  for (const auto& [name, held] : of(cls).by_name) out.push_back(&held->record);
  return out;
}

std::vector<const Record*> RecordStore::changes(RecordClass cls, std::uint64_t& cursor) const {
  std::vector<const Record*> out;
  const auto& by_change = of(cls).by_change;
  for (auto it = by_change.upper_bound(cursor); it != by_change.end(); ++it) {
    out.push_back(&it->second->record);
  }
  cursor = last_change_;
  return out;
}

const std::vector<DigestEntry>& RecordStore::digest() const {
  if (digest_version_ == version_) return digest_;
  digest_.clear();
  digest_.reserve(streams_.size());
  for (const auto& [id, stream] : streams_) {
    SeqSet beyond;
    for (auto it = stream.held.upper_bound(stream.complete); it != stream.held.end(); ++it) {
      beyond.insert(it->first);
    }
    if (stream.complete == 0 && beyond.empty()) continue;
    digest_.push_back({id.author(), id.cls, stream.complete, beyond.ranges()});
  }
  std::ranges::sort(digest_, {}, [](const DigestEntry& e) { return std::pair(e.author, e.cls); });
  digest_version_ = version_;
  return digest_;
}

void RecordStore::raise(Author author, RecordClass cls, std::uint64_t complete) {
  if (!is_class(cls) || complete == 0 || is_voided(author, cls)) return;
  if (author == Author{self_, epoch_}) return;
  Stream& stream = streams_[{author.robot, cls, author.epoch}];
  if (complete <= stream.complete) return;
  stream.complete = stream.seen.advance(complete);
  stream.version = ++version_;
}

void RecordStore::resume(const StreamId& id, std::uint64_t complete,
                         std::span<const SeqRange> seen) {
  if (!is_class(id.cls) || is_voided(id.author(), id.cls)) return;
  Stream& stream = streams_[id];
  for (const SeqRange& range : seen) stream.seen.insert(range);
  stream.complete = stream.seen.advance(std::max(complete, stream.complete));
  stream.version = ++version_;
}

bool RecordStore::covers(const StreamId& id, std::uint64_t complete,
                         std::span<const SeqRange> beyond) const {
  if (complete == 0 && beyond.empty()) return true;
  if (is_voided(id.author(), id.cls)) return true;
  const auto it = streams_.find(id);
  if (it == streams_.end()) return false;
  const Stream& stream = it->second;
  if (complete > stream.complete) return false;
  return std::ranges::all_of(beyond, [&](const SeqRange& range) {
    return range.last <= stream.complete ||
           stream.seen.contains(SeqRange{std::max(range.first, stream.complete + 1), range.last});
  });
}

}  // namespace muster::store
