#include "gcs/results_db.h"

#include <filesystem>

#include "common/core/error.h"
#include "common/store/database.h"

namespace muster::gcs {
namespace {

using store::Database;

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

/// One row; `sql` has a `?` per value.
template <class... Values>
void insert(Database& db, const char* sql, const Values&... values) {
  db.prepare(sql).with(values...).step();
}

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
    insert(db, "INSERT INTO robots VALUES(?,?,?,?)", r.id.value, mission::role_name(r.role), heard,
           lost_at);
    const auto* health = k.health(r.id);
    if (!health) continue;
    for (const mission::RegionProgress& p : health->body.regions) {
      insert(db, "INSERT OR REPLACE INTO regions VALUES(?,?,?,?,?,?,?)", p.region.value, r.id.value,
             text(p.state), static_cast<double>(p.explored_m3), static_cast<double>(p.volume_m3),
             p.areas_found, p.areas_inspected);
    }
  }
  for (const auto& [ref, known] : k.areas()) {
    const mission::Area& a = known.area;
    insert(db, "INSERT INTO areas VALUES(?,?,?,?,?,?,?,?,?)", ref.author.value, ref.key,
           a.position.x(), a.position.y(), a.position.z(), a.region.value, a.feature_type,
           a.sightings, known.stamp.s());
  }
  for (const auto& [ref, result] : k.results()) {
    const mission::Inspection& i = result.inspection;
    insert(db, "INSERT INTO inspections VALUES(?,?,?,?,?,?,?)", ref.author.value, ref.key,
           result.by.value, i.done.s(), i.found ? 1 : 0, i.payload_bytes,
           result.complete() ? 1 : 0);
    for (const mission::Finding& f : i.findings) {
      insert(db, "INSERT INTO findings VALUES(?,?,?,?,?,?,?)", ref.author.value, ref.key,
             f.feature.value, f.feature_type, f.position.x(), f.position.y(), f.position.z());
    }
    if (i.parts > 1 && result.complete()) {
      insert(db, "INSERT INTO images VALUES(?,?,?,?)", ref.author.value, ref.key, result.by.value,
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
      db.execute("PRAGMA journal_mode=MEMORY");
      db.execute("BEGIN");
      db.execute(kSchema);
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
