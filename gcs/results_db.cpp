#include "gcs/results_db.h"

#include <sqlite3.h>

#include <filesystem>
#include <memory>

#include "common/core/error.h"

namespace muster::gcs {
namespace {

constexpr const char* kSchema = R"sql(
CREATE TABLE robots(id INTEGER PRIMARY KEY, role TEXT, last_heard_s REAL, lost_at_s REAL);
CREATE TABLE areas(author INTEGER, key INTEGER, x REAL, y REAL, z REAL, region INTEGER, feature_type INTEGER, sightings INTEGER,
                   written_s REAL, PRIMARY KEY(author, key));
CREATE TABLE inspections(area_author INTEGER, area_key INTEGER, robot INTEGER, done_s REAL, found INTEGER, image_bytes INTEGER,
                         image_complete INTEGER, PRIMARY KEY(area_author, area_key));
CREATE TABLE findings(area_author INTEGER, area_key INTEGER, feature INTEGER, feature_type INTEGER, x REAL, y REAL, z REAL);
CREATE TABLE images(area_author INTEGER, area_key INTEGER, robot INTEGER, image BLOB);
CREATE TABLE regions(id INTEGER PRIMARY KEY, explorer INTEGER, state TEXT, explored_m3 REAL, volume_m3 REAL, areas_found INTEGER, areas_inspected INTEGER);
CREATE VIEW features AS
  SELECT feature, min(feature_type) AS feature_type, avg(x) AS x, avg(y) AS y, avg(z) AS z, count(*) AS times_found
  FROM findings GROUP BY feature ORDER BY feature;
)sql";

struct Close {
  void operator()(sqlite3* db) const { sqlite3_close(db); }
  void operator()(sqlite3_stmt* s) const { sqlite3_finalize(s); }
};

class Database {
 public:
  explicit Database(const std::string& path) {
    sqlite3* db = nullptr;
    const int rc = sqlite3_open(path.c_str(), &db);
    db_.reset(db);
    check(rc);
    execute("PRAGMA journal_mode=MEMORY");
    execute("BEGIN");
    execute(kSchema);
  }
  void execute(const char* sql) { check(sqlite3_exec(db_.get(), sql, nullptr, nullptr, nullptr)); }

  /// One row; `sql` has a `?` per value.
  template <class... Values>
  void insert(const char* sql, const Values&... values) {
    sqlite3_stmt* s = nullptr;
    check(sqlite3_prepare_v2(db_.get(), sql, -1, &s, nullptr));
    const std::unique_ptr<sqlite3_stmt, Close> statement(s);
    int at = 0;
    (bind(s, ++at, values), ...);
    if (sqlite3_step(s) != SQLITE_DONE) check(sqlite3_errcode(db_.get()));
  }

 private:
  void check(int rc) const {
    if (rc != SQLITE_OK) throw Failure(sqlite3_errmsg(db_.get()));
  }
  void bind(sqlite3_stmt* s, int at, double v) { check(sqlite3_bind_double(s, at, v)); }
  template <std::integral T>
  void bind(sqlite3_stmt* s, int at, T v) {
    check(sqlite3_bind_int64(s, at, static_cast<sqlite3_int64>(v)));
  }
  void bind(sqlite3_stmt* s, int at, const std::optional<SimTime>& v) {
    check(v ? sqlite3_bind_double(s, at, v->s()) : sqlite3_bind_null(s, at));
  }
  void bind(sqlite3_stmt* s, int at, const char* v) {
    check(sqlite3_bind_text(s, at, v, -1, SQLITE_TRANSIENT));
  }
  void bind(sqlite3_stmt* s, int at, const Bytes& v) {
    check(sqlite3_bind_blob(s, at, v.data(), static_cast<int>(v.size()), SQLITE_TRANSIENT));
  }

  std::unique_ptr<sqlite3, Close> db_;
};

const char* text(mission::RegionState state) {
  switch (state) {
    case mission::RegionState::kPending:
      return "pending";
    case mission::RegionState::kAssigned:
      return "assigned";
    case mission::RegionState::kExplored:
      return "explored";
    case mission::RegionState::kDone:
      return "done";
  }
  return "";
}

Bytes image_of(const robot::Knowledge& k, const mission::AreaRef& area,
               const robot::ResultKnown& result) {
  Bytes image;
  for (std::uint32_t part = 1; part < result.inspection.parts; ++part) {
    const store::Record* r =
        k.store().find(result.by, store::RecordClass::kImage, robot::image_key(area, part));
    if (!r) return {};
    const auto body = dds::decode_body<mission::Inspection>(k.store().whole(*r));
    image.insert(image.end(), body.payload.begin(), body.payload.end());
  }
  return image;
}

void fill(Database& db, const robot::Knowledge& k) {
  for (const mission::RobotConfig& r : k.mission().fleet) {
    const auto lost = k.declared_lost().find(r.id);
    std::optional<SimTime> lost_at;
    if (lost != k.declared_lost().end()) lost_at = lost->second;
    const auto heard = r.id == k.self() ? std::optional(k.now()) : k.last_heard(r.id);
    db.insert("INSERT INTO robots VALUES(?,?,?,?)", r.id.value, mission::role_name(r.role), heard,
              lost_at);
    const auto* health = k.health(r.id);
    if (!health) continue;
    for (const mission::RegionProgress& p : health->body.regions) {
      db.insert("INSERT OR REPLACE INTO regions VALUES(?,?,?,?,?,?,?)", p.region.value, r.id.value,
                text(p.state), static_cast<double>(p.explored_m3), static_cast<double>(p.volume_m3),
                p.areas_found, p.areas_inspected);
    }
  }
  for (const auto& [ref, known] : k.areas()) {
    const mission::Area& a = known.area;
    db.insert("INSERT INTO areas VALUES(?,?,?,?,?,?,?,?,?)", ref.author.value, ref.key,
              a.position.x(), a.position.y(), a.position.z(), a.region.value, a.feature_type,
              a.sightings, known.stamp.s());
  }
  for (const auto& [ref, result] : k.results()) {
    const mission::Inspection& i = result.inspection;
    db.insert("INSERT INTO inspections VALUES(?,?,?,?,?,?,?)", ref.author.value, ref.key,
              result.by.value, i.done.s(), i.found ? 1 : 0, i.payload_bytes,
              result.complete() ? 1 : 0);
    for (const mission::Finding& f : i.findings) {
      db.insert("INSERT INTO findings VALUES(?,?,?,?,?,?,?)", ref.author.value, ref.key,
                f.feature.value, f.feature_type, f.position.x(), f.position.y(), f.position.z());
    }
    if (i.parts > 1 && result.complete()) {
      db.insert("INSERT INTO images VALUES(?,?,?,?)", ref.author.value, ref.key, result.by.value,
                image_of(k, ref, result));
    }
  }
}

}  // namespace

void write_results(const robot::Knowledge& k, const std::string& path) {
  const std::string fresh = path + ".new";
  try {
    std::filesystem::remove(fresh);
    {
      Database db(fresh);
      fill(db, k);
      db.execute("COMMIT");
    }
    std::filesystem::rename(fresh, path);
  } catch (const std::filesystem::filesystem_error& e) {
    throw Failure(path + ": cannot be written: " + e.code().message());
  } catch (const Failure& e) {
    throw Failure(path + ": cannot be written: " + e.what());
  }
}

}  // namespace muster::gcs
