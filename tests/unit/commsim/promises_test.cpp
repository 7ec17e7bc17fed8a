#include "commsim/promises.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "common/dds/convert.h"
#include "common/store/database.h"
#include "common/store/journal.h"
#include "commsim/relay.h"

using namespace muster;
using namespace muster::commsim;
using store::Journal;
using store::RecordClass;
using store::RecordHeader;
using store::RecordStore;
namespace fs = std::filesystem;

namespace {

constexpr RobotId kA{1}, kB{2};

mission::Message said(const RecordHeader& header, RobotId by = kA) {
  const auto cls = mission::message_class(header.cls);
  const store::Record record = header.cls == RecordClass::kPlan
                                   ? dds::encode_record(header, mission::Plan{})
                                   : dds::encode_record(header, mission::Area{});
  return dds::wrap({1, by, cls, SimTime{}}, record);
}

RecordHeader area(std::uint64_t key, std::uint64_t seq, std::uint64_t epoch = 1) {
  return {{kA, epoch}, RecordClass::kArea, key, seq, SimTime{}, {}};
}

mission::Message promise(RobotId by, std::vector<store::DigestEntry> digest) {
  mission::Beacon b;
  b.envelope = {1, by, mission::MessageClass::kBeacon, SimTime{}};
  b.digest_n = 1;
  b.digest = std::move(digest);
  return dds::encode(b);
}

store::DigestEntry all_up_to(std::uint64_t n, std::vector<store::SeqRange> beyond = {}) {
  return {{kA, 1}, RecordClass::kArea, n, std::move(beyond)};
}

std::size_t lost(Promises& promises, const std::vector<RecordHeader>& journal) {
  promises.judge(kB, journal, SimTime::from_s(9));
  return promises.lost();
}

}  // namespace

TEST_CASE("who promised holds what it promised, or a newer one in its place") {
  Promises promises;
  for (std::uint64_t seq = 1; seq <= 4; ++seq) promises.sent(kA, said(area(seq % 2, seq)));
  promises.sent(kB, promise(kB, {all_up_to(2)}));
  SECTION("all of it") { CHECK(lost(promises, {area(1, 1), area(0, 2)}) == 0); }
  SECTION("a newer version") { CHECK(lost(promises, {area(1, 3), area(0, 2)}) == 0); }
  SECTION("of a newer epoch") { CHECK(lost(promises, {area(1, 1, 2), area(0, 2)}) == 0); }
  SECTION("one is missing") {
    CHECK(lost(promises, {area(0, 2)}) == 1);
    CHECK(lost(promises, {area(0, 2)}) == 1);  // and is counted once
    const auto told = promises.to_json();
    CHECK(told["records"][0]["robot"] == 2);
    CHECK(told["records"][0]["author"] == 1);
    CHECK(told["records"][0]["class"] == "area");
    CHECK(told["records"][0]["seq"] == 1);
    CHECK(told["records"][0]["t_s"] == 9.0);
  }
  SECTION("no promise, no loss") {
    Promises silent;
    silent.sent(kA, said(area(1, 1)));
    CHECK(lost(silent, {}) == 0);
  }
}

TEST_CASE("what was said to be held beyond is promised, the gap before it is not") {
  Promises promises;
  for (std::uint64_t seq = 1; seq <= 5; ++seq) promises.sent(kA, said(area(seq, seq)));
  promises.sent(kB, promise(kB, {all_up_to(1, {{4, 5}})}));
  CHECK(lost(promises, {area(1, 1), area(4, 4), area(5, 5)}) == 0);
  CHECK(lost(promises, {area(1, 1), area(5, 5)}) == 1);
}

TEST_CASE("an older promise is not taken back by a newer one that says less") {
  Promises promises;
  promises.sent(kA, said(area(1, 1)));
  promises.sent(kB, promise(kB, {all_up_to(1)}));
  promises.sent(kB, promise(kB, {}));
  CHECK(lost(promises, {}) == 1);
}

TEST_CASE("what a newer start of its author voids may be gone, areas may not") {
  Promises promises;
  const RecordHeader plan{{kA, 1}, RecordClass::kPlan, 1, 1, SimTime{}, {}};
  promises.sent(kA, said(plan));
  promises.sent(kA, said(area(1, 1)));
  promises.sent(kB, promise(kB, {{{kA, 1}, RecordClass::kPlan, 1, {}}, all_up_to(1)}));
  CHECK(lost(promises, {area(1, 1), area(7, 1, 2)}) == 0);
  CHECK(lost(promises, {area(7, 1, 2)}) == 1);
  CHECK(lost(promises, {area(7, 1, 1)}) == 2);  // no newer start: the plan is missing as well
}

TEST_CASE("who was started again on a new disk is held to what it promised since") {
  const fs::path dir = fs::temp_directory_path() / ("muster_newdisk_" + std::to_string(getpid()));
  const std::string file = Journal::path(dir.string(), kB);
  mission::Mission mission;
  for (const RobotId id : {kA, kB}) mission.fleet.emplace_back().id = id;
  const bool replaced = GENERATE(false, true);
  mission.script = {{SimTime::from_s(0.1), "kill", kB}, {SimTime::from_s(0.2), "revive", kB}};
  mission.script.back().journal_lost = replaced;
  Relay relay(mission, [](const Vec3&, const Vec3&) { return true; });
  relay.judge_journals_in(dir.string());
  RecordStore store(kB, 1);
  store.merge(dds::encode_record(area(1, 1), mission::Area{}));
  Journal(file, kB, Journal::Durability::kProcess).commit(store);

  mission::Truth truth;
  truth.robots = {{kA, mission::VehicleState::kMoving, {}, Vec3::Zero()},
                  {kB, mission::VehicleState::kMoving, {}, Vec3::Zero()}};
  relay.step(truth, {{kA, {said(area(1, 1))}}, {kB, {promise(kB, store.digest())}}});
  relay.set_alive(kB, false);
  CHECK(relay.summary()["records_lost"]["count"] == 0);
  truth.k = 1;
  truth.time = SimTime::from_s(0.1);
  relay.step(truth, {});
  Journal::lose(file);
  RecordStore fresh(kB, 2);
  Journal(file, kB, Journal::Durability::kProcess).commit(fresh);
  relay.set_alive(kB, true);
  relay.finish();
  CHECK(relay.summary()["records_lost"]["count"] == (replaced ? 0 : 1));
  fs::remove_all(dir);
}

TEST_CASE("a record dropped from the journal of a robot that died is found, by whoever relays") {
  const fs::path dir = fs::temp_directory_path() / ("muster_promises_" + std::to_string(getpid()));
  const std::string file = Journal::path(dir.string(), kB);
  mission::Mission mission;
  for (const RobotId id : {kA, kB}) mission.fleet.emplace_back().id = id;
  Relay relay(mission, [](const Vec3&, const Vec3&) { return true; });
  relay.judge_journals_in(dir.string());
  RecordStore store(kB, 1);
  {
    Journal journal(file, kB, Journal::Durability::kProcess);
    for (std::uint64_t seq = 1; seq <= 3; ++seq) {
      store.merge(dds::encode_record(area(seq, seq), mission::Area{}));
    }
    journal.commit(store);
  }
  const bool dropped = GENERATE(false, true);
  if (dropped) store::Database(file).execute("DELETE FROM records WHERE seq = 2");

  mission::Truth truth;
  truth.robots = {{kA, mission::VehicleState::kMoving, {}, Vec3::Zero()},
                  {kB, mission::VehicleState::kMoving, {}, Vec3::Zero()}};
  std::vector<mission::Message> records;
  for (std::uint64_t seq = 1; seq <= 3; ++seq) records.push_back(said(area(seq, seq)));
  relay.step(truth, {{kA, records}, {kB, {promise(kB, store.digest())}}});
  relay.set_alive(kB, false);
  const auto told = relay.summary()["records_lost"];
  CHECK(told["count"] == (dropped ? 1 : 0));
  CHECK(told["journals"] == 1);
  if (dropped) CHECK(told["records"][0]["seq"] == 2);
  fs::remove_all(dir);
}
