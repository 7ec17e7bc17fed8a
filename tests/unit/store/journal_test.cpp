#include "common/store/journal.h"

#include <fmt/format.h>
#include <rapidcheck.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "common/core/error.h"

using namespace muster;
using namespace muster::store;
namespace fs = std::filesystem;

namespace {

constexpr RobotId kSelf{1}, kOther{2};

/// A folder of this test's own, gone with it.
struct Folder {
  Folder() { fs::create_directories(dir); }
  ~Folder() { fs::remove_all(dir); }
  fs::path dir = fs::temp_directory_path() / fmt::format("muster_journal_{}", getpid());
  std::string file(const char* name = "1.db") const { return (dir / name).string(); }
};

Record record(RobotId robot, std::uint64_t epoch, RecordClass cls, std::uint64_t key,
              std::uint64_t seq, std::size_t size = 8) {
  return {{{robot, epoch},
           cls,
           key,
           seq,
           SimTime{static_cast<std::int64_t>(seq)},
           Bytes{7, static_cast<std::uint8_t>(key)}},
          Bytes(size, static_cast<std::uint8_t>(seq))};
}

void write_own(RecordStore& store, RecordClass cls, std::uint64_t key) {
  const RecordHeader header = store.next_header(cls, key, {});
  store.insert_own({header, Bytes{static_cast<std::uint8_t>(key)}});
}

/// What is left when the process is killed: the file as it is on disk, nothing closed.
std::string as_killed(const std::string& path, const std::string& copy) {
  for (const char* part : {"", "-wal"}) {
    fs::remove(copy + part);
    if (fs::exists(path + part)) fs::copy_file(path + part, copy + part);
  }
  fs::remove(copy + "-shm");
  return copy;
}

/// For looking at, not for reading bodies: its journal is closed again.
RecordStore restored(const std::string& path) {
  Journal journal(path, kSelf, Journal::Durability::kProcess);
  RecordStore store(kSelf, journal.epoch() + 1);
  journal.restore(store, [](const Record&) {});
  return store;
}

using Looks = std::vector<std::pair<RegionId, Bytes>>;

Looks looks(const std::string& path) {
  Looks kept;
  Journal(path, kSelf, Journal::Durability::kProcess)
      .restore_looks([&](RegionId explored, const Bytes& sightings) {
        kept.emplace_back(explored, sightings);
      });
  return kept;
}

bool same(const RecordStore& a, const RecordStore& b) {
  const auto equal = [](const DigestEntry& x, const DigestEntry& y) {
    return x.author == y.author && x.cls == y.cls && x.complete == y.complete &&
           x.beyond == y.beyond;
  };
  return a.content_hash() == b.content_hash() && std::ranges::equal(a.digest(), b.digest(), equal);
}

}  // namespace

TEST_CASE("a robot killed at any instant starts again with all that it had committed") {
  const Folder folder;
  CHECK(rc::check([&] {
    fs::remove_all(folder.dir);
    fs::create_directories(folder.dir);
    auto journal = std::make_unique<Journal>(folder.file(), kSelf, Journal::Durability::kProcess);
    RecordStore store(kSelf, 1);
    RecordStore committed = restored(folder.file("empty.db"));
    const int steps = *rc::gen::inRange(1, 40);
    for (int i = 0; i < steps; ++i) {
      const auto cls = static_cast<RecordClass>(*rc::gen::inRange(1, 9));
      const auto seq = *rc::gen::inRange<std::uint64_t>(1, 12);
      switch (*rc::gen::inRange(0, 4)) {
        case 0:
          write_own(store, cls, seq % 5);
          break;
        case 1:
          // One number is one record: its key goes with it.
          store.merge(record(kOther, *rc::gen::inRange<std::uint64_t>(1, 4), cls, seq % 5, seq));
          break;
        case 2:
          store.raise({kOther, *rc::gen::inRange<std::uint64_t>(1, 4)}, cls, seq);
          break;
        default:
          journal->commit(store);
          committed = restored(as_killed(folder.file(), folder.file("killed.db")));
          RC_ASSERT(same(committed, store));
          RC_ASSERT(committed.epoch() == store.epoch() + 1);
      }
    }
    RC_ASSERT(same(restored(as_killed(folder.file(), folder.file("killed.db"))), committed));
  }));
}

TEST_CASE("records come back as their authors wrote them, in the order in which they came") {
  const Folder folder;
  const Record late = record(kOther, 1, RecordClass::kArea, 9, 3),
               early = record(kOther, 1, RecordClass::kArea, 4, 8, 100'000);
  {
    Journal journal(folder.file(), kSelf, Journal::Durability::kPower);
    RecordStore store(kSelf, 1);
    store.merge(early);
    journal.commit(store);
    store.merge(late);
    journal.commit(store);
  }
  Journal journal(folder.file(), kSelf, Journal::Durability::kPower);
  RecordStore store(kSelf, 2);
  std::vector<Record> taken;
  journal.restore(store, [&](const Record& r) { taken.push_back(r); });
  REQUIRE(taken.size() == 2);
  CHECK(taken[0].bytes == early.bytes);
  CHECK(taken[0].header.signature == early.header.signature);
  CHECK(taken[0].header.stamp == early.header.stamp);
  CHECK(taken[1].header.version() == late.header.version());
}

TEST_CASE("a journal has the images, and the memory is free of them") {
  const Folder folder;
  Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
  RecordStore plain(kSelf, 1), store(kSelf, 1);
  const std::vector<Record> records{record(kOther, 1, RecordClass::kImage, 7, 1, 16'000),
                                    record(kOther, 1, RecordClass::kMap, 3, 1, 2'000),
                                    record(kOther, 1, RecordClass::kInspection, 7, 1, 2'000),
                                    record(kOther, 1, RecordClass::kImage, 8, 2, 20)};
  for (const Record& r : records) {
    plain.merge(r);
    store.merge(r);
  }
  const auto hold_the_same = [&] {
    Bytes buffer;
    for (const Record& r : records) {
      const RecordHeader& h = r.header;
      const Record* a = plain.find(kOther, h.cls, h.key);
      const Record* b = store.find(kOther, h.cls, h.key);
      CHECK(std::ranges::equal(store.read(*b, buffer).bytes, a->bytes));
      CHECK(store.size_of(*b) == a->bytes.size());
    }
    CHECK(store.content_hash() == plain.content_hash());
  };
  const Record* image = store.find(kOther, RecordClass::kImage, 7);
  CHECK(image->bytes.size() == 16'000);
  journal.commit(store);
  CHECK(image->bytes.capacity() == 0);
  CHECK(store.find(kOther, RecordClass::kInspection, 7)->bytes.empty());
  CHECK(store.find(kOther, RecordClass::kMap, 3)->bytes.size() == 2'000);
  hold_the_same();
  const Record newer = record(kOther, 1, RecordClass::kImage, 7, 3, 5'000);
  plain.merge(newer);
  store.merge(newer);
  hold_the_same();
  journal.commit(store);
  hold_the_same();

  Database(folder.file()).execute("DELETE FROM records");
  Bytes buffer;
  CHECK_THROWS_WITH(store.read(*store.find(kOther, RecordClass::kImage, 7), buffer),
                    Catch::Contains(folder.file() + ": a record that was kept is gone"));
}

TEST_CASE("what was kept before a restart is read from the journal after it, too") {
  const Folder folder;
  const Record image = record(kOther, 1, RecordClass::kImage, 7, 1, 16'000);
  {
    Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
    RecordStore store(kSelf, 1);
    store.merge(image);
    journal.commit(store);
  }
  Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
  RecordStore store(kSelf, 2);
  journal.restore(store, [&](const Record& r) { CHECK(r.bytes == image.bytes); });
  write_own(store, RecordClass::kArea, 1);
  journal.commit(store);
  const Record* held = store.find(kOther, RecordClass::kImage, 7);
  CHECK(held->bytes.empty());
  Bytes buffer;
  CHECK(std::ranges::equal(store.read(*held, buffer).bytes, image.bytes));
}

TEST_CASE("what a newer start of its author voids leaves the file, too") {
  const Folder folder;
  Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
  RecordStore store(kSelf, 1);
  store.merge(record(kOther, 1, RecordClass::kPlan, 1, 1));
  store.merge(record(kOther, 1, RecordClass::kArea, 1, 1));
  journal.commit(store);
  store.merge(record(kOther, 2, RecordClass::kStatus, 1, 1));
  journal.commit(store);
  auto count = Database(folder.file()).prepare("SELECT count(*) FROM records");
  CHECK(count.step());
  CHECK(count.integer(0) == 2);
}

TEST_CASE("own map evidence is kept, the newest of each block") {
  const Folder folder;
  {
    Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
    RecordStore store(kSelf, 1);
    journal.keep_block(5, {1});
    journal.keep_block(3, {2});
    journal.commit(store);
    journal.keep_block(5, {3});
    journal.commit(store);
  }
  std::map<std::uint64_t, Bytes> blocks;
  Journal(folder.file(), kSelf, Journal::Durability::kProcess)
      .restore_blocks([&](std::uint64_t key, const Bytes& voxels) { blocks[key] = voxels; });
  CHECK(blocks == std::map<std::uint64_t, Bytes>{{3, {2}}, {5, {3}}});
}

TEST_CASE("looks are kept once each, in the order in which they came") {
  const Folder folder;
  const RegionId region{2};
  {
    Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
    RecordStore store(kSelf, 1);
    journal.keep_look(region, {3, 1});
    journal.commit(store);
    journal.set_disk_full(true);
    journal.keep_look(kNoRegion, {2});
    journal.commit(store);
    CHECK(looks(as_killed(folder.file(), folder.file("killed.db"))) == Looks{{region, {3, 1}}});
    journal.set_disk_full(false);
    while (!journal.works()) journal.commit(store);
    journal.keep_look(region, {1});
    journal.commit(store);
  }
  CHECK(looks(folder.file()) == Looks{{region, {3, 1}}, {kNoRegion, {2}}, {region, {1}}});
}

TEST_CASE("a journal from before looks were kept is gone on with") {
  const Folder folder;
  RecordStore store(kSelf, 1);
  write_own(store, RecordClass::kArea, 1);
  Journal(folder.file(), kSelf, Journal::Durability::kProcess).commit(store);
  Database(folder.file()).execute("DROP TABLE looks");
  Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
  CHECK(journal.epoch() == 1);
  journal.keep_look(RegionId{0}, {1});
  journal.commit(store);
  CHECK(looks(as_killed(folder.file(), folder.file("killed.db"))).size() == 1);
}

TEST_CASE("a damaged journal is put aside, whole, and a new one begun") {
  const Folder folder;
  {
    Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
    RecordStore store(kSelf, 7);
    for (std::uint64_t k = 0; k < 200; ++k) write_own(store, RecordClass::kArea, k);
    journal.commit(store);
  }
  const auto size = fs::file_size(folder.file());
  SECTION("overwritten") {
    std::fstream file(folder.file(), std::ios::in | std::ios::out | std::ios::binary);
    file.write("this was a journal", 18);
  }
  SECTION("torn inside") {
    std::fstream file(folder.file(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(std::streamoff{4096} * 2);
    file << std::string(4096, '\xff');
  }
  SECTION("with a column lost") {
    Database(folder.file()).execute("ALTER TABLE streams DROP COLUMN seen");
  }
  SECTION("with a table lost") { Database(folder.file()).execute("DROP TABLE records"); }
  const Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
  CHECK(journal.epoch() == 0);
  CHECK(journal.works());
  CHECK(fs::file_size(folder.file("1.db.damaged")) == size);  // not a page less
}

TEST_CASE("a journal of another robot is refused, and left as it is") {
  const Folder folder;
  RecordStore theirs(kOther, 3);
  Journal(folder.file(), kOther, Journal::Durability::kProcess).commit(theirs);
  CHECK_THROWS_WITH(Journal(folder.file(), kSelf, Journal::Durability::kProcess),
                    Catch::Contains("belongs to robot 2, not to 1"));
  CHECK(Journal(folder.file(), kOther, Journal::Durability::kProcess).epoch() == 3);
}

TEST_CASE("a journal whose robot is just closing it is judged when it is closed") {
  const Folder folder;
  RecordStore store(kSelf, 1);
  write_own(store, RecordClass::kArea, 1);
  Journal(folder.file(), kSelf, Journal::Durability::kProcess).commit(store);
  auto closing = std::make_unique<Database>(folder.file());
  closing->execute("PRAGMA locking_mode=EXCLUSIVE");
  closing->execute("UPDATE journal SET epoch = 1");
  CHECK_THROWS_WITH(Database(folder.file()).execute("SELECT * FROM records"),
                    Catch::Contains("locked"));
  std::atomic<bool> asked = false;
  std::jthread closer([&] {
    asked.wait(false);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // it has been found locked by now
    closing.reset();
  });
  asked = true;
  asked.notify_one();
  CHECK(Journal::kept(folder.file()).size() == 1);
}

TEST_CASE("where nothing can be written there is no journal, and it says where") {
  CHECK_THROWS_AS(Journal("/proc/none/1.db", kSelf, Journal::Durability::kProcess), Failure);
  CHECK_THROWS_WITH(Journal("/proc/none/1.db", kSelf, Journal::Durability::kProcess),
                    Catch::Contains("/proc/none/1.db"));
}

TEST_CASE("with the disk full the robot goes on, keeps what it had, and catches up later") {
  const Folder folder;
  Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
  RecordStore store(kSelf, 1);
  write_own(store, RecordClass::kArea, 1);
  journal.commit(store);
  const RecordStore before = restored(as_killed(folder.file(), folder.file("killed.db")));

  // No file may grow any more: what a full disk does, for this process only.
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  rlimit unlimited{};
  getrlimit(RLIMIT_FSIZE, &unlimited);
  const rlimit full{fs::file_size(folder.file("1.db-wal")), unlimited.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  store.merge(record(kOther, 1, RecordClass::kImage, 1, 1, 1 << 20));
  journal.commit(store);
  CHECK_FALSE(journal.works());
  setrlimit(RLIMIT_FSIZE, &unlimited);
  std::signal(SIGXFSZ, ignored);

  CHECK(same(restored(as_killed(folder.file(), folder.file("killed.db"))), before));
  for (int i = 0; i < 200 && !journal.works(); ++i) journal.commit(store);
  CHECK(journal.works());
  CHECK(same(restored(as_killed(folder.file(), folder.file("killed.db"))), store));
}

TEST_CASE(
    "a disk that is full for a while, by script, is caught up with as soon as it is tried again") {
  const Folder folder;
  Journal journal(folder.file(), kSelf, Journal::Durability::kProcess);
  RecordStore store(kSelf, 1);
  write_own(store, RecordClass::kArea, 1);
  journal.commit(store);
  journal.set_disk_full(true);
  write_own(store, RecordClass::kArea, 2);
  for (int i = 0; i < 150; ++i) journal.commit(store);
  CHECK_FALSE(journal.works());
  CHECK(restored(as_killed(folder.file(), folder.file("killed.db"))).size() == 1);
  journal.set_disk_full(false);
  for (int i = 0; i < 150; ++i) journal.commit(store);
  CHECK(journal.works());
  CHECK(same(restored(as_killed(folder.file(), folder.file("killed.db"))), store));
}
