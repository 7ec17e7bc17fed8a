#include "common/store/record_store.h"

#include <rapidcheck.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "common/core/random.h"

using namespace muster;
using namespace muster::store;

namespace {

constexpr RobotId kSelf{1}, kOther{2};

Record record(RobotId robot, std::uint64_t epoch, RecordClass cls, std::uint64_t key,
              std::uint64_t seq) {
  return {{{robot, epoch}, cls, key, seq, {}, {}}, Bytes{static_cast<std::uint8_t>(seq)}};
}

DigestEntry digest_of(const RecordStore& store, Author author, RecordClass cls) {
  for (const DigestEntry& e : store.digest()) {
    if (e.author == author && e.cls == cls) return e;
  }
  return {author, cls, 0, {}};
}

}  // namespace

TEST_CASE("sets of sequence numbers join, split and advance like plain sets") {
  CHECK(rc::check([] {
    const auto numbers =
        *rc::gen::container<std::vector<std::uint8_t>>(rc::gen::inRange<std::uint8_t>(1, 40));
    const auto widths = *rc::gen::container<std::vector<std::uint8_t>>(
        numbers.size(), rc::gen::inRange<std::uint8_t>(0, 5));
    SeqSet set;
    std::set<std::uint64_t> plain;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const std::uint64_t first = numbers[i], last = first + widths[i];
      set.insert(SeqRange{first, last});
      for (std::uint64_t s = first; s <= last; ++s) plain.insert(s);
    }
    std::uint64_t previous_last = 0;
    for (const SeqRange& r : set.ranges()) {
      RC_ASSERT(previous_last == 0 || r.first > previous_last + 1);
      previous_last = r.last;
    }
    for (std::uint64_t s = 1; s < 50; ++s) RC_ASSERT(set.contains(s) == plain.contains(s));
    std::uint64_t n = *rc::gen::inRange<std::uint64_t>(0, 45);
    const std::uint64_t reached = set.advance(n);
    while (plain.contains(n + 1)) ++n;
    RC_ASSERT(reached == n);
    for (std::uint64_t s = 1; s < 50; ++s)
      RC_ASSERT(set.contains(s) == (s > n && plain.contains(s)));
  }));
}

TEST_CASE("own records count per class and are complete as they are written") {
  RecordStore store(kSelf, 7);
  for (std::uint64_t i = 1; i <= 3; ++i) {
    const RecordHeader h = store.next_header(RecordClass::kArea, 10 + i, SimTime::from_s(1));
    CHECK(h.seq == i);
    CHECK(h.author == Author{kSelf, 7});
    store.insert_own({h, {}});
  }
  CHECK(store.next_header(RecordClass::kPlan, 1, {}).seq == 1);
  const DigestEntry entry = digest_of(store, {kSelf, 7}, RecordClass::kArea);
  CHECK(entry.complete == 3);
  CHECK(entry.beyond.empty());
}

TEST_CASE("the newest version of a key wins whatever the order of arrival") {
  RecordStore store(kSelf, 1);
  CHECK(store.merge(record(kOther, 1, RecordClass::kArea, 5, 3)) == Merged::kNew);
  CHECK(store.merge(record(kOther, 1, RecordClass::kArea, 5, 2)) == Merged::kOlder);
  CHECK(store.merge(record(kOther, 1, RecordClass::kArea, 5, 3)) == Merged::kDuplicate);
  CHECK(store.find(kOther, RecordClass::kArea, 5)->header.seq == 3);
  CHECK(store.merge(record(kOther, 2, RecordClass::kArea, 5, 1)) == Merged::kNew);
  CHECK(store.find(kOther, RecordClass::kArea, 5)->header.author.epoch == 2);
  CHECK(store.size() == 1);
  CHECK(store.merge(record(kOther, 1, RecordClass{99}, 5, 1)) == Merged::kRefused);
  CHECK(store.merge(record(kOther, 1, RecordClass::kArea, 5, 0)) == Merged::kRefused);
}

TEST_CASE("a gap in the numbers stays a gap until somebody vouches for it") {
  RecordStore store(kSelf, 1);
  const Author author{kOther, 1};
  for (std::uint64_t seq : {1, 2, 4, 5, 8})
    store.merge(record(kOther, 1, RecordClass::kMap, seq, seq));
  DigestEntry entry = digest_of(store, author, RecordClass::kMap);
  CHECK(entry.complete == 2);
  CHECK(entry.beyond == std::vector<SeqRange>{{4, 5}, {8, 8}});
  store.raise(author, RecordClass::kMap, 6);
  entry = digest_of(store, author, RecordClass::kMap);
  CHECK(entry.complete == 6);
  CHECK(entry.beyond == std::vector<SeqRange>{{8, 8}});
  store.merge(record(kOther, 1, RecordClass::kMap, 7, 7));
  CHECK(digest_of(store, author, RecordClass::kMap).complete == 8);
}

TEST_CASE("a newer start of a robot voids its plans, meetings and status, not what it found") {
  RecordStore store(kSelf, 1);
  for (std::uint32_t c = 1; c <= kRecordClasses; ++c)
    store.merge(record(kOther, 1, RecordClass{c}, 1, 1));
  store.merge(record(kOther, 2, RecordClass::kRequest, 2, 1));
  for (std::uint32_t c = 1; c <= kRecordClasses; ++c) {
    const RecordClass cls{c};
    CHECK((store.find(kOther, cls, 1) == nullptr) == voided_by_restart(cls));
    CHECK(store.voided(cls) == (voided_by_restart(cls) ? 1 : 0));
  }
  CHECK(store.merge(record(kOther, 1, RecordClass::kPlan, 1, 9)) == Merged::kOlder);
  store.raise({kOther, 1}, RecordClass::kPlan, 9);
  CHECK(digest_of(store, {kOther, 1}, RecordClass::kPlan).complete == 0);
}

TEST_CASE("a robot that hears a later start of its own goes above it") {
  RecordStore store(kSelf, 5);
  store.insert_own({store.next_header(RecordClass::kStatus, 1, {}), {}});
  const std::uint64_t key = store.new_key(RecordClass::kArea);
  CHECK(store.merge(record(kSelf, 9, RecordClass::kArea, 1, 1)) == Merged::kNew);
  CHECK(store.epoch() == 10);
  CHECK(store.find(kSelf, RecordClass::kStatus, 1) == nullptr);
  CHECK(store.next_header(RecordClass::kStatus, 1, {}).author.epoch == 10);
  CHECK(store.new_key(RecordClass::kArea) != key);
}

TEST_CASE("readers see each change once, and only the newest of a key") {
  RecordStore store(kSelf, 1);
  std::uint64_t cursor = 0;
  store.merge(record(kOther, 1, RecordClass::kArea, 1, 1));
  store.merge(record(kOther, 1, RecordClass::kArea, 2, 2));
  store.merge(record(kOther, 1, RecordClass::kArea, 1, 3));
  auto changed = store.changes(RecordClass::kArea, cursor);
  REQUIRE(changed.size() == 2);
  CHECK(changed[0]->header.key == 2);
  CHECK(changed[1]->header.seq == 3);
  CHECK(store.changes(RecordClass::kArea, cursor).empty());
  const Record* kept = store.find(kOther, RecordClass::kArea, 2);
  store.merge(record(kOther, 1, RecordClass::kArea, 3, 4));
  CHECK(store.changes(RecordClass::kArea, cursor).size() == 1);
  CHECK(store.find(kOther, RecordClass::kArea, 2) == kept);
}

TEST_CASE("merging is commutative, associative and idempotent") {
  CHECK(rc::check([] {
    const auto gen =
        rc::gen::map(rc::gen::tuple(rc::gen::inRange<std::uint64_t>(1, 4),
                                    rc::gen::inRange<std::uint32_t>(1, kRecordClasses + 1),
                                    rc::gen::inRange<std::uint64_t>(1, 12)),
                     [](const auto& t) {
                       // A seq belongs to one key: the author never numbers two records alike.
                       const auto [epoch, cls, seq] = t;
                       return record(kOther, epoch, RecordClass{cls}, (seq * 7 + epoch) % 3, seq);
                     });
    const auto records = *rc::gen::container<std::vector<Record>>(gen);
    auto shuffled = records;
    Random random(*rc::gen::arbitrary<std::uint64_t>(), kSelf, "shuffle");
    for (std::size_t i = shuffled.size(); i > 1; --i)
      std::swap(shuffled[i - 1], shuffled[random.below(i)]);
    RecordStore a(kSelf, 1), b(kSelf, 1);
    for (const Record& r : records) a.merge(r);
    for (const Record& r : shuffled) {
      b.merge(r);
      b.merge(r);
    }
    RC_ASSERT(a.content_hash() == b.content_hash());
    RC_ASSERT(a.size() == b.size());
    RC_ASSERT(a.digest().size() == b.digest().size());
    for (const DigestEntry& e : a.digest()) {
      RC_ASSERT(b.covers({e.author.robot, e.cls, e.author.epoch}, e.complete, e.beyond));
    }
  }));
}
