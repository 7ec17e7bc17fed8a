#include "gcs/results_db.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "common/store/database.h"
#include "tests/text_of.h"
#include "tests/unit/robot/fixtures.h"

using namespace muster;
using store::Database;
using store::RecordClass;
namespace fs = std::filesystem;

namespace {

constexpr RobotId kStation{0}, kExplorer{1}, kInspector{2};

template <class Body>
void hear(robot::Knowledge& k, RobotId from, RecordClass cls, std::uint64_t key, std::uint64_t seq,
          const Body& body) {
  k.receive(from, seq,
            dds::encode_record({{from, 1}, cls, key, seq, SimTime::from_s(5), {}}, body));
}

/// Of two areas, one of which held a feature, and of a meeting that the explorer wants.
void tell(robot::Knowledge& k) {
  k.begin(SimTime::from_s(60));
  mission::Beacon beacon;
  beacon.envelope.src = kExplorer;
  beacon.epoch = 1;
  beacon.pose.p = Vec3(1, 2, 3);
  beacon.battery = 0.5F;
  k.hear(beacon);
  for (std::uint64_t key : {7, 8}) {
    mission::Area area;
    area.position = Vec3(4, 5, static_cast<double>(key));
    area.region = RegionId{0};
    hear(k, kExplorer, RecordClass::kArea, key, key - 6, area);
    mission::Inspection result;
    result.area = {kExplorer, key};
    result.done = SimTime::from_s(50);
    result.parts = 1;
    result.found = key == 7;
    if (result.found) result.findings.push_back({FeatureId{3}, 1, Vec3(4, 5, 6)});
    hear(k, kInspector, RecordClass::kInspection, robot::result_key(result.area), key - 6, result);
  }
  mission::Meeting proposal;
  proposal.meeting = MeetingId{4};
  proposal.proposer = kExplorer;
  proposal.partner = kStation;
  proposal.ladder = {{Vec3(1, 1, 1), SimTime::from_s(90), SimTime::from_s(120)},
                     {Vec3(2, 1, 1), SimTime::from_s(130), SimTime::from_s(150)}};
  hear(k, kExplorer, RecordClass::kMeeting,
       robot::meeting_key(kStation, mission::MeetingKind::kProposal), 1, proposal);
}

/// Rows as text, columns apart by |.
std::vector<std::string> rows(Database& db, const std::string& sql, int columns) {
  std::vector<std::string> out;
  auto statement = db.prepare(sql.c_str());
  while (statement.step()) {
    std::string row;
    for (int i = 0; i < columns; ++i) {
      if (i > 0) row += '|';
      row += statement.text(i);
    }
    out.push_back(row);
  }
  return out;
}

struct Results {
  explicit Results(const std::function<void(robot::Knowledge&)>& more = [](auto&) {}) {
    const mission::Mission m = robot::small_mission();
    robot::Knowledge k(m, kStation, 1);
    tell(k);
    more(k);
    const std::vector<gcs::Contact> contacts{{kExplorer, SimTime::from_s(1), SimTime::from_s(3.5)},
                                             {kExplorer, SimTime::from_s(60), SimTime::from_s(61)}};
    gcs::write_results(k, contacts, path.string());
  }
  ~Results() { fs::remove(path); }
  const fs::path path = fs::temp_directory_path() / ("muster_results_" + std::to_string(getpid()));
};

}  // namespace

TEST_CASE("station.db says by name what was found, by whom, and who was met") {
  const Results results;
  Database db(results.path.string());
  using Rows = std::vector<std::string>;
  CHECK(rows(db, "SELECT feature, x_m, y_m, z_m, times_found, first_done_s FROM features", 6) ==
        Rows{"3|4.0|5.0|6.0|1|50.0"});
  CHECK(rows(db, "SELECT area_key, robot, found, done_s FROM inspections", 4) ==
        Rows{"7|2|1|50.0", "8|2|0|50.0"});
  CHECK(rows(db,
             "SELECT role, last_heard_s, x_m, z_m, battery, lost_at_s FROM robots WHERE robot = 1",
             6) == Rows{"explorer|60.0|1.0|3.0|0.5|"});
  CHECK(rows(db,
             "SELECT proposer, partner, meeting, agreed, proposed_s, x_m, from_s, until_s, "
             "fallbacks FROM meetings",
             9) == Rows{"1|0|4|0|5.0|1.0|90.0|120.0|1"});
}

TEST_CASE("station.db has a row for every box, by the assignment and what explorers last said") {
  const Results results([](robot::Knowledge& k) {
    mission::Plan plan;
    plan.kind = mission::PlanKind::kAssignment;
    plan.allocations = {{kNoRobot, kExplorer, RegionId{0}, {}}};
    k.publish(RecordClass::kPlan, robot::plan_key(plan.kind), plan);
  });
  Database surveyed(results.path.string());
  const std::string query =
      "SELECT region, explorer, state, explored_m3 < volume_m3, areas_found FROM regions";
  CHECK(rows(surveyed, query, 5) == std::vector<std::string>{"0|1|surveyed|1|2"});

  const Results told([](robot::Knowledge& k) {
    mission::Status health;
    health.regions = {{.region = RegionId{0}, .state = mission::RegionState::kExplored}};
    hear(k, kExplorer, RecordClass::kStatus, robot::kHealthKey, 1, health);
  });
  Database explored(told.path.string());
  CHECK(rows(explored, query, 5) == std::vector<std::string>{"0|1|explored|1|2"});
}

TEST_CASE("a meeting is agreed when exactly this proposal was acknowledged") {
  const auto agreed_with = [](std::uint64_t seq) {
    const Results results([&](robot::Knowledge& k) {
      mission::Meeting ack;
      ack.kind = mission::MeetingKind::kAcknowledgement;
      ack.proposer = kExplorer;
      ack.partner = kStation;
      ack.ack_epoch = 1;
      ack.ack_seq = seq;
      k.publish(RecordClass::kMeeting, robot::meeting_key(kExplorer, ack.kind), ack);
    });
    Database db(results.path.string());
    return rows(db, "SELECT agreed FROM meetings", 1);
  };
  CHECK(agreed_with(1) == std::vector<std::string>{"1"});
  CHECK(agreed_with(2) == std::vector<std::string>{"0"});
}

TEST_CASE("the queries in the station's README give what they say") {
  const std::string readme = test::text_of(MUSTER_SOURCE_DIR "/gcs/README.md");
  auto query = [&, at = std::size_t{0}]() mutable {
    const std::string begin = "```sql\n";
    const std::size_t from = readme.find(begin, at) + begin.size();
    at = readme.find("```", from);
    return readme.substr(from, at - from);
  };
  const Results results;
  Database db(results.path.string());
  CHECK(rows(db, query(), 5) == std::vector<std::string>{"1|8|4.0|5.0|8.0"});
  const auto robots = rows(db, query(), 4);
  REQUIRE(robots.size() == robot::small_mission().fleet.size());
  CHECK(robots[1] == "1|explorer|0|3.5");
  CHECK(robots[2] == "2|inspector|2|");
}

TEST_CASE("the station's log of contacts has one entry per contact") {
  const mission::Mission m = robot::small_mission();
  robot::Knowledge k(m, kStation, 1);
  gcs::ContactLog log;
  mission::Beacon beacon;
  beacon.envelope.src = kExplorer;
  for (const double t_s : {1.0, 1.3, 1.6, 9.0}) {
    k.begin(SimTime::from_s(t_s - 0.2));
    log.update(k);
    k.begin(SimTime::from_s(t_s));
    k.hear(beacon);
    log.update(k);
  }
  REQUIRE(log.contacts().size() == 2);
  CHECK(log.contacts()[0].from == SimTime::from_s(1));
  CHECK(log.contacts()[0].until == SimTime::from_s(1.6));
  CHECK(log.contacts()[1].from == SimTime::from_s(9));
}
