#include "common/store/journal.h"

#include <filesystem>

#include "common/core/error.h"
#include "common/core/log.h"

namespace muster::store {
namespace {

constexpr int kVersion = 1;
constexpr int kTryAgainAfter = 100;  // commits, that is about 10 s
constexpr Duration kPatience{10'000'000};

constexpr const char* kSchema = R"sql(
CREATE TABLE journal(version INTEGER, robot INTEGER, epoch INTEGER);
CREATE TABLE records(change INTEGER PRIMARY KEY, robot INTEGER, class INTEGER, key INTEGER,
                     epoch INTEGER, seq INTEGER, stamp_us INTEGER, signature BLOB, bytes BLOB,
                     UNIQUE(robot, class, key));
CREATE TABLE streams(robot INTEGER, class INTEGER, epoch INTEGER, complete INTEGER, seen BLOB,
                     PRIMARY KEY(robot, class, epoch)) WITHOUT ROWID;
CREATE TABLE blocks(key INTEGER PRIMARY KEY, voxels BLOB);
)sql";
// Younger than the rest: there are journals of this version without it.
constexpr const char* kLooks =
    "CREATE TABLE IF NOT EXISTS looks(n INTEGER PRIMARY KEY, region INTEGER, sightings BLOB)";

Bytes encode(const std::vector<SeqRange>& ranges) {
  Bytes bytes;
  for (const SeqRange& range : ranges) {
    for (const std::uint64_t n : {range.first, range.last}) {
      for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<std::uint8_t>(n >> (8 * i)));
    }
  }
  return bytes;
}

std::vector<SeqRange> decode(const Bytes& bytes) {
  const auto number = [&](std::size_t at) {
    std::uint64_t n = 0;
    for (std::size_t i = 0; i < 8; ++i) n |= std::uint64_t{bytes[at + i]} << (8 * i);
    return n;
  };
  std::vector<SeqRange> ranges;
  for (std::size_t at = 0; at + 16 <= bytes.size(); at += 16) {
    ranges.push_back({number(at), number(at + 8)});
  }
  return ranges;
}

/// Moves a damaged journal out of the way, with all that belongs to it.
void put_aside(const std::string& path) {
  std::string aside = path + ".damaged";
  for (int i = 2; std::filesystem::exists(aside); ++i) {
    aside = path + ".damaged." + std::to_string(i);
  }
  for (const char* part : {"-wal", "-shm", ""}) {
    std::error_code none;  // most often there is no -wal
    std::filesystem::rename(path + part, aside + part, none);
  }
  log::error("journal {}: damaged; kept as {}, and a new one begun", path, aside);
}

/// Of a row that begins with robot, class, key, epoch, seq.
RecordHeader header_of(const Database::Statement& row) {
  RecordHeader h;
  h.author = {RobotId{static_cast<std::uint32_t>(row.number(0))}, row.number(3)};
  h.cls = static_cast<RecordClass>(row.integer(1));
  h.key = row.number(2);
  h.seq = row.number(4);
  return h;
}

}  // namespace

struct Journal::Statements {
  explicit Statements(Database& db)
      : record(db.prepare("INSERT OR REPLACE INTO records(robot, class, key, epoch, seq, stamp_us, "
                          "signature, bytes) VALUES(?,?,?,?,?,?,?,?)")),
        stream(db.prepare("INSERT OR REPLACE INTO streams VALUES(?,?,?,?,?)")),
        block(db.prepare("INSERT OR REPLACE INTO blocks VALUES(?,?)")),
        look(db.prepare("INSERT INTO looks(region, sightings) VALUES(?,?)")),
        epoch(db.prepare("UPDATE journal SET epoch = ?")),
        body(db.prepare("SELECT bytes FROM records WHERE robot = ? AND class = ? AND key = ? AND "
                        "epoch = ? AND seq = ?")),
        // What a newer start of its author voids.
        void_older(db.prepare(
            "DELETE FROM records WHERE class IN (2, 4, 6) AND epoch < "
            "(SELECT max(epoch) FROM records AS newer WHERE newer.robot = records.robot)")) {
    static_assert(voided_by_restart(RecordClass{2}) && voided_by_restart(RecordClass{4}) &&
                  voided_by_restart(RecordClass{6}));
  }
  /// Lets go of what is bound, so that nothing keeps the file busy.
  void reset() {
    for (auto* s : {&record, &stream, &block, &look, &epoch, &body, &void_older}) s->reset();
  }
  Database::Statement record, stream, block, look, epoch, body, void_older;
};

Journal::Journal(const std::string& path, RobotId robot, Durability durability) : path_(path) {
  std::error_code none;  // what is wrong shows itself when the file is opened
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), none);
  try {
    try {
      open(robot, durability);
    } catch (const Damaged&) {
      db_.reset();
      put_aside(path);
      open(robot, durability);
    }
  } catch (const Failure& e) {
    throw Failure("journal " + path + ": " + e.what());
  }
}

Journal::~Journal() = default;

void Journal::open(RobotId robot, Durability durability) {
  db_ = std::make_unique<Database>(path_);
  Database& db = *db_;
  db.execute("PRAGMA journal_mode=WAL");
  db.execute(durability == Durability::kPower ? "PRAGMA synchronous=FULL"
                                              : "PRAGMA synchronous=NORMAL");
  auto check = db.prepare("PRAGMA quick_check(1)");
  if (!check.step() || check.text(0) != "ok") throw Damaged("its pages do not fit together");
  check.reset();
  auto tables = db.prepare("SELECT count(*) FROM sqlite_master");
  tables.step();
  const bool empty = tables.integer(0) == 0;
  tables.reset();
  if (empty) {
    db.execute("BEGIN");
    db.execute(kSchema);
    db.prepare("INSERT INTO journal VALUES(?,?,0)").with(kVersion, robot.value).step();
    db.execute("COMMIT");
  }
  auto whose = db.prepare("SELECT version, robot, epoch FROM journal");
  if (!whose.step()) throw Damaged("it does not say whose it is");
  if (whose.integer(0) != kVersion)
    throw BadInput("journal " + path_ + ": of version " + std::to_string(whose.integer(0)) +
                   "; this program reads version " + std::to_string(kVersion));
  if (whose.number(1) != robot.value)
    throw BadInput("journal " + path_ + ": belongs to robot " + std::to_string(whose.number(1)) +
                   ", not to " + std::to_string(robot.value));
  epoch_ = whose.number(2);
  whose.reset();
  db.execute(kLooks);
  sql_ = std::make_unique<Statements>(db);
}

void Journal::lose(const std::string& path) {
  std::error_code none;
  for (const char* part : {"", "-wal", "-shm"}) std::filesystem::remove(path + part, none);
}

std::vector<RecordHeader> Journal::kept(const std::string& path) {
  // Its robot may be about to close it, which locks it for a moment.
  Database db(path, kPatience);
  auto rows = db.prepare("SELECT robot, class, key, epoch, seq FROM records");
  std::vector<RecordHeader> headers;
  while (rows.step()) {
    headers.push_back(header_of(rows));
  }
  return headers;
}

void Journal::restore(RecordStore& store, const std::function<void(const Record&)>& take) {
  auto rows = db_->prepare(
      "SELECT robot, class, key, epoch, seq, stamp_us, signature, bytes FROM records ORDER BY "
      "change");
  while (rows.step()) {
    RecordHeader h = header_of(rows);
    h.stamp = SimTime{rows.integer(5)};
    h.signature = rows.blob(6);
    if (store.merge({h, rows.blob(7)}) != Merged::kNew) continue;
    const Record& held = *store.find(h.author.robot, h.cls, h.key);
    take(held);
    store.kept(held, *this);
  }
  auto streams = db_->prepare("SELECT robot, class, epoch, complete, seen FROM streams");
  while (streams.step()) {
    const StreamId id{RobotId{static_cast<std::uint32_t>(streams.number(0))},
                      static_cast<RecordClass>(streams.integer(1)), streams.number(2)};
    store.resume(id, streams.number(3), decode(streams.blob(4)));
  }
  // None of it has to be written again.
  for (std::uint32_t c = 1; c <= kRecordClasses; ++c)
    store.changes(static_cast<RecordClass>(c), written_.changes[c - 1]);
  written_.version = store.version();
}

void Journal::restore_blocks(const std::function<void(std::uint64_t, const Bytes&)>& take) {
  auto rows = db_->prepare("SELECT key, voxels FROM blocks ORDER BY key");
  while (rows.step()) take(rows.number(0), rows.blob(1));
}

void Journal::restore_looks(const std::function<void(RegionId, const Bytes&)>& take) {
  auto rows = db_->prepare("SELECT region, sightings FROM looks ORDER BY n");
  while (rows.step()) take(RegionId{static_cast<std::uint32_t>(rows.number(0))}, rows.blob(1));
}

void Journal::keep_block(std::uint64_t key, Bytes voxels) { blocks_[key] = std::move(voxels); }

void Journal::keep_look(RegionId explored, Bytes sightings) {
  looks_.emplace_back(explored, std::move(sightings));
}

bool Journal::has_news(const RecordStore& store) const {
  return store.version() != written_.version || store.epoch() != written_.epoch ||
         !blocks_.empty() || !looks_.empty();
}

void Journal::read(const RecordHeader& h, Bytes& into) const {
  sql_->body.with(h.author.robot.value, static_cast<std::uint32_t>(h.cls), h.key, h.author.epoch,
                  h.seq);
  if (!sql_->body.step()) throw Failure("journal " + path_ + ": a record that was kept is gone");
  sql_->body.blob(0, into);
  sql_->body.reset();
}

void Journal::commit(RecordStore& store) {
  if (!has_news(store) || (!works_ && ++skip_ < kTryAgainAfter)) return;
  skip_ = 0;
  const Written before = written_;
  try {
    db_->execute("BEGIN");
    write(store);
    if (disk_full_) throw Failure("database or disk is full");
    db_->execute("COMMIT");
    blocks_.clear();
    looks_.clear();
    for (const Record* record : fresh_) store.kept(*record, *this);
    if (!works_) log::info("journal {}: written again, and up to date", path_);
    works_ = true;
  } catch (const Failure& e) {
    written_ = before;
    sql_->reset();
    try {
      db_->execute("ROLLBACK");
    } catch (const Failure&) {
      // SQLite has rolled back by itself.
    }
    if (works_) {
      log::error("journal {}: {}; flying on without, what is in it is kept, tried again", path_,
                 e.what());
    }
    works_ = false;
  }
}

void Journal::write(const RecordStore& store) {
  fresh_.clear();
  if (store.epoch() != written_.epoch) sql_->epoch.with(store.epoch()).step();
  written_.epoch = store.epoch();
  std::uint64_t voided = 0;
  for (std::uint32_t c = 1; c <= kRecordClasses; ++c) {
    const auto cls = static_cast<RecordClass>(c);
    voided += store.voided(cls);
    for (const Record* record : store.changes(cls, written_.changes[c - 1])) {
      const RecordHeader& h = record->header;
      sql_->record
          .with(h.author.robot.value, c, h.key, h.author.epoch, h.seq, h.stamp.us, h.signature,
                record->bytes)
          .step();
      fresh_.push_back(record);
    }
  }
  if (voided != written_.voided) sql_->void_older.with().step();
  written_.voided = voided;
  write_streams(store);
  for (const auto& [key, voxels] : blocks_) sql_->block.with(key, voxels).step();
  for (const auto& [explored, sightings] : looks_)
    sql_->look.with(explored.value, sightings).step();
  sql_->reset();
}

void Journal::write_streams(const RecordStore& store) {
  for (const auto& [id, stream] : store.streams()) {
    if (stream.version <= written_.version) continue;
    sql_->stream
        .with(id.robot.value, static_cast<std::uint32_t>(id.cls), id.epoch, stream.complete,
              encode(stream.seen.ranges()))
        .step();
  }
  written_.version = store.version();
}

}  // namespace muster::store
