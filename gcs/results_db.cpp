#include "gcs/results_db.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "common/core/error.h"
#include "common/store/database.h"

namespace muster::gcs {
namespace {

using store::Database;

constexpr const char* kSchema = R"sql(
CREATE TABLE robots(robot INTEGER PRIMARY KEY, role TEXT, last_heard_s REAL, lost_at_s REAL,
                    x_m REAL, y_m REAL, z_m REAL, battery REAL);
CREATE TABLE regions(region INTEGER PRIMARY KEY, explorer INTEGER, state TEXT, explored_m3 REAL, volume_m3 REAL,
                     areas_found INTEGER, areas_inspected INTEGER);
CREATE TABLE areas(author INTEGER, key INTEGER, x_m REAL, y_m REAL, z_m REAL, region INTEGER, feature_type INTEGER,
                   sightings INTEGER, written_s REAL, PRIMARY KEY(author, key));
CREATE TABLE inspections(area_author INTEGER, area_key INTEGER, robot INTEGER, done_s REAL, found INTEGER, image_bytes INTEGER,
                         image_complete INTEGER, PRIMARY KEY(area_author, area_key));
CREATE TABLE findings(area_author INTEGER, area_key INTEGER, feature INTEGER, feature_type INTEGER,
                      x_m REAL, y_m REAL, z_m REAL);
CREATE TABLE images(area_author INTEGER, area_key INTEGER, robot INTEGER, image BLOB);
CREATE TABLE meetings(proposer INTEGER, partner INTEGER, meeting INTEGER, agreed INTEGER, region INTEGER, proposed_s REAL,
                      x_m REAL, y_m REAL, z_m REAL, from_s REAL, until_s REAL, fallbacks INTEGER,
                      PRIMARY KEY(proposer, partner));
CREATE TABLE contacts(robot INTEGER, from_s REAL, until_s REAL);
CREATE VIEW features AS
  SELECT feature, min(feature_type) AS feature_type, avg(x_m) AS x_m, avg(y_m) AS y_m, avg(z_m) AS z_m,
         count(*) AS times_found, min(done_s) AS first_done_s
  FROM findings NATURAL JOIN inspections GROUP BY feature ORDER BY feature;
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
    case mission::RegionState::kSurveyed:
      return "surveyed";
    case mission::RegionState::kDone:
      return "done";
  }
  return "";
}

Bytes image_of(const robot::Knowledge& k, const mission::AreaRef& area,
               const robot::ResultKnown& result) {
  Bytes image, buffer;
  for (std::uint32_t part = 1; part < result.inspection.parts; ++part) {
    const store::Record* r =
        k.store().find(result.by, store::RecordClass::kImage, robot::image_key(area, part));
    if (!r) return {};
    const auto body = dds::decode_body<mission::Inspection>(k.store().read(*r, buffer));
    image.insert(image.end(), body.payload.begin(), body.payload.end());
  }
  return image;
}

void fill_robots(Database& db, const robot::Knowledge& k) {
  for (const mission::RobotConfig& r : k.mission().fleet) {
    const bool self = r.id == k.self();
    const auto lost = k.declared_lost().find(r.id);
    const auto mate = k.teammates().find(r.id);
    std::optional<SimTime> heard, lost_at;
    std::optional<Vec3> p;
    std::optional<double> battery;
    if (lost != k.declared_lost().end()) lost_at = lost->second;
    if (mate != k.teammates().end()) {
      heard = mate->second.heard;
      p = mate->second.beacon.pose.p;
      battery = static_cast<double>(mate->second.beacon.battery);
    }
    if (self) heard = k.now(), p = k.position(), battery = static_cast<double>(k.battery().charge);
    const auto axis = [&](int i) { return p ? std::optional((*p)[i]) : std::nullopt; };
    insert(db, "INSERT INTO robots VALUES(?,?,?,?,?,?,?,?)", r.id.value, mission::role_name(r.role),
           heard, lost_at, axis(0), axis(1), axis(2), battery);
  }
}

/// By this station's assignment, of what its explorers last said, and its own map.
void fill_regions(Database& db, const robot::Knowledge& k) {
  struct Region {
    std::optional<RobotId> explorer;
    mission::RegionState state = mission::RegionState::kPending;
  };
  std::vector<Region> regions(k.mission().boxes.size());
  if (const auto* plan = k.plan(k.self(), mission::PlanKind::kAssignment)) {
    for (const mission::Allocation& a : plan->body.allocations) {
      if (a.region.value >= regions.size()) continue;
      Region& region = regions[a.region.value];
      if (robot::says_done(a))
        region.state = mission::RegionState::kDone;
      else if (robot::says_surveyed(a))
        region = {a.leader, mission::RegionState::kSurveyed};
    }
  }
  for (const RobotId explorer : k.mission().with_role(mission::Role::kExplorer)) {
    const auto* health = k.health(explorer);
    if (!health) continue;
    for (const mission::RegionProgress& p : health->body.regions) {
      if (p.region.value >= regions.size()) continue;
      Region& region = regions[p.region.value];
      if (!region.explorer || p.state >= region.state)
        region = {explorer, std::max(p.state, region.state)};
    }
  }
  for (std::uint32_t i = 0; i < regions.size(); ++i) {
    const auto& [explorer, state] = regions[i];
    const robot::AreaCount areas = k.areas_in(RegionId{i});
    const std::size_t box = k.map().watch(k.mission().boxes[i]);
    insert(db, "INSERT INTO regions VALUES(?,?,?,?,?,?,?)", i,
           explorer ? std::optional(explorer->value) : std::nullopt, text(state),
           k.map().known_m3(box), k.map().volume_m3(box), areas.found, areas.inspected);
  }
}

void fill_areas(Database& db, const robot::Knowledge& k) {
  for (const auto& [ref, known] : k.areas()) {
    const mission::Area& a = known.area;
    insert(db, "INSERT INTO areas VALUES(?,?,?,?,?,?,?,?,?)", ref.author.value, ref.key,
           a.position.x(), a.position.y(), a.position.z(), a.region.value, a.feature_type,
           a.unexplained, known.stamp);
  }
}

void fill_results(Database& db, const robot::Knowledge& k) {
  for (const auto& [ref, result] : k.results()) {
    const mission::Inspection& i = result.inspection;
    insert(db, "INSERT INTO inspections VALUES(?,?,?,?,?,?,?)", ref.author.value, ref.key,
           result.by.value, i.done, i.found ? 1 : 0, i.payload_bytes, result.complete() ? 1 : 0);
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

/// Is there an acknowledgement of exactly this proposal?
bool is_agreed(const robot::Knowledge& k, const store::RecordHeader& proposal, RobotId partner) {
  const auto* ack =
      k.meeting(partner, proposal.author.robot, mission::MeetingKind::kAcknowledgement);
  return ack && ack->body.ack_epoch == proposal.author.epoch && ack->body.ack_seq == proposal.seq;
}

void fill_meetings(Database& db, const robot::Knowledge& k) {
  for (const mission::RobotConfig& proposer : k.mission().fleet) {
    for (const mission::RobotConfig& partner : k.mission().fleet) {
      const auto* m = k.meeting(proposer.id, partner.id, mission::MeetingKind::kProposal);
      if (!m || m->body.ladder.empty()) continue;
      const mission::Rung& first = m->body.ladder.front();
      insert(db, "INSERT INTO meetings VALUES(?,?,?,?,?,?,?,?,?,?,?,?)", proposer.id.value,
             partner.id.value, m->body.meeting.value, is_agreed(k, m->header, partner.id) ? 1 : 0,
             m->body.region.value, m->header.stamp, first.place.x(), first.place.y(),
             first.place.z(), first.from, first.until, m->body.ladder.size() - 1);
    }
  }
}

void fill(Database& db, const robot::Knowledge& k, std::span<const Contact> contacts) {
  fill_robots(db, k);
  fill_regions(db, k);
  fill_areas(db, k);
  fill_results(db, k);
  fill_meetings(db, k);
  for (const Contact& c : contacts)
    insert(db, "INSERT INTO contacts VALUES(?,?,?)", c.robot.value, c.from, c.until);
}

}  // namespace

void write_results(const robot::Knowledge& k, std::span<const Contact> contacts,
                   const std::string& path) {
  const std::string fresh = path + ".new";
  try {
    std::filesystem::remove(fresh);
    {
      Database db(fresh);
      db.execute("PRAGMA journal_mode=MEMORY");
      db.execute("BEGIN");
      db.execute(kSchema);
      fill(db, k, contacts);
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
