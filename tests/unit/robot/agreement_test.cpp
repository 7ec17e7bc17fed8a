#include "common/robot/agreement.h"

#include <catch2/catch.hpp>

#include "tests/unit/robot/fixtures.h"

using namespace muster;
using robot::Agreement;
using robot::Knowledge;

namespace {

SimTime at(double s) { return SimTime::from_s(s); }

struct Pair {
  mission::Mission mission = robot::small_mission();
  Knowledge station{mission, RobotId{0}, 1}, explorer{mission, RobotId{1}, 1};
  Agreement at_station{RobotId{0}, RobotId{1}}, at_explorer{RobotId{1}, RobotId{0}};

  void time(double s, bool contact) {
    station.begin(at(s));
    explorer.begin(at(s));
    if (!contact) return;
    robot::hear(station, explorer);
    robot::hear(explorer, station);
  }
  void exchange() {
    robot::pass(explorer, station, store::RecordClass::kMeeting);
    robot::pass(station, explorer, store::RecordClass::kMeeting);
  }
  /// In contact, for 60 s and 120 s. The explorer has not heard yet that the station accepts.
  void propose_and_accept() {
    time(0, true);
    at_explorer.propose(explorer, ladder(60), RegionId{0});
    exchange();
    REQUIRE(at_station.update(station));
  }
  std::vector<mission::Rung> ladder(double from) {
    return {{{2, -4, 1}, at(from), at(from + 30)}, {{2, -4, 1}, at(from + 60), at(from + 90)}};
  }
};

}  // namespace

TEST_CASE("a meeting is agreed on when the acknowledgement is heard in the same contact") {
  Pair p;
  p.time(0, true);
  p.at_explorer.propose(p.explorer, p.ladder(60), RegionId{0});
  CHECK(p.at_explorer.pending());
  CHECK_FALSE(p.at_explorer.update(p.explorer));
  p.exchange();
  CHECK(p.at_station.update(p.station));  // the acknowledger follows at once
  CHECK(p.at_station.next(p.station).from == at(60));
  CHECK(p.at_explorer.number() == 0);  // the proposer not before it hears so
  p.exchange();
  CHECK(p.at_explorer.update(p.explorer));
  CHECK(p.at_explorer.next(p.explorer).from == at(60));
  CHECK(p.at_explorer.number() == 1);
  CHECK_FALSE(p.at_station.update(p.station));  // nothing new
}

TEST_CASE("an explorer that lost its journal takes up what the station agreed with it before") {
  Pair p;
  p.propose_and_accept();
  Knowledge blank(p.mission, RobotId{1}, 2);
  blank.begin(at(5));
  Agreement again(RobotId{1}, RobotId{0});
  again.be_told(blank);
  CHECK(again.number() == 0);
  robot::pass(p.station, blank, store::RecordClass::kMeeting);
  again.be_told(blank);
  CHECK(again.number() == 1);
  CHECK(again.next(blank).from == at(60));
}

TEST_CASE(
    "an acknowledgement that comes after the contact is void, and both meet at the standing rung") {
  Pair p;
  p.propose_and_accept();
  p.time(5, false);  // contact broken before the acknowledgement arrived
  CHECK_FALSE(p.at_explorer.update(p.explorer));
  CHECK_FALSE(p.at_explorer.pending());
  robot::pass(p.station, p.explorer,
              store::RecordClass::kMeeting);  // a third robot brings it later
  CHECK_FALSE(p.at_explorer.update(p.explorer));
  p.at_explorer.be_told(p.explorer);
  CHECK(p.at_explorer.number() == 0);
  p.time(200, false);
  CHECK(p.at_station.next(p.station).from == at(300));
  CHECK(p.at_explorer.next(p.explorer).from == at(300));
  CHECK(p.at_station.next(p.station).place == p.at_explorer.next(p.explorer).place);
}

TEST_CASE("rungs that passed were missed, standing ones included") {
  Pair p;
  p.propose_and_accept();
  p.time(89, false);
  CHECK(p.at_station.missed(p.station) == 0);
  p.time(95, false);
  CHECK(p.at_station.missed(p.station) == 1);
  CHECK(p.at_station.next(p.station).from == at(120));
  p.time(160, false);
  CHECK(p.at_station.missed(p.station) == 2);
  p.time(335, false);
  CHECK(p.at_station.missed(p.station) == 3);
  CHECK(p.at_station.next(p.station).from == at(420));
  p.time(455, false);
  CHECK(p.at_station.missed(p.station) == 4);
}

TEST_CASE("the standing rung repeats for ever") {
  const mission::StandingConfig s = robot::small_mission().standing;
  CHECK(robot::standing_rung(s, at(0)).from == at(300));
  CHECK(robot::standing_rung(s, at(330)).from == at(300));
  CHECK(robot::standing_rung(s, at(330.1)).from == at(420));
  CHECK(robot::standing_rung(s, at(3600)).until >= at(3600));
}

TEST_CASE(
    "regress: who starts again in the middle of a mission has missed no meeting before that") {
  Knowledge station(robot::small_mission(), RobotId{0}, 2);
  Agreement agreement(RobotId{0}, RobotId{1});
  station.begin(at(972));
  CHECK(agreement.next(station).from == at(1020));
  CHECK(agreement.missed(station) == 0);
  station.begin(at(1051));
  CHECK(agreement.missed(station) == 1);
  station.begin(at(1171));
  CHECK(agreement.missed(station) == 2);
}

TEST_CASE("who starts again goes on with what was agreed on") {
  Pair p;
  p.propose_and_accept();
  p.exchange();
  REQUIRE(p.at_explorer.update(p.explorer));

  Agreement station(RobotId{0}, RobotId{1}), explorer(RobotId{1}, RobotId{0});
  station.resume(p.station);
  explorer.resume(p.explorer);
  for (const auto* side : {&station, &explorer}) CHECK(side->number() == 1);
  CHECK(station.next(p.station).from == at(60));
  CHECK(explorer.next(p.explorer).from == at(60));
  CHECK_FALSE(station.update(p.station));  // what was acknowledged is not acknowledged again
  p.time(91, false);
  CHECK(explorer.next(p.explorer).from == at(120));
}

TEST_CASE("a window has passed only when it has passed on a clock that may be right as well") {
  Pair p;
  p.propose_and_accept();
  const Duration bound = Duration::from_s(20);
  p.station.begin(at(109), bound);
  CHECK(p.at_station.next(p.station).from == at(60));
  CHECK(p.at_station.missed(p.station) == 0);
  p.station.begin(at(111), bound);
  CHECK(p.at_station.next(p.station).from == at(120));
  CHECK(p.at_station.missed(p.station) == 1);
}
