// Clocks that are wrong by a minute, in whole flights in memory.
#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>
#include <vector>

#include "common/core/log.h"
#include "common/mission/mission.h"
#include "tests/fleet/open_fleet.h"

using namespace muster;

namespace {

constexpr RobotId kStation{1}, kExplorer{2};
constexpr double kSkewed_s = 30, kContact_s = 1.2, kUntil_s = 720;

mission::Mission skewed(RobotId robot, double by_s) {
  auto mission =
      mission::Mission::load(std::string(MUSTER_SOURCE_DIR) + "/deploy/missions/pagoda.yaml", {});
  mission::ScriptedEvent skew{SimTime::from_s(kSkewed_s), "skew", robot};
  skew.value = by_s;
  mission.script.push_back(skew);
  return mission;
}

/// Flies, and keeps book of what station and explorer agreed and whether it was kept.
class Flight {
 public:
  Flight(RobotId robot, double by_s) : robot_(robot), fleet_(skewed(robot, by_s)) {
    spdlog::set_level(spdlog::level::err);
    while (fleet_.now().s() < kUntil_s && !fleet_.tick()) note();
  }

  /// When the skewed robot first heard anyone afterwards.
  std::optional<double> contact_s;
  int agreed = 0;           ///< meetings of station and explorer, since then
  std::vector<int> missed;  ///< when they should have been
  /// Of clocks, at the end.
  double spread_s() const {
    SimTime least = knows(kStation).now(), most = least;
    for (const auto& [id, robot] : fleet_.robots()) {
      least = std::min(least, robot->knowledge().now());
      most = std::max(most, robot->knowledge().now());
    }
    return (most - least).s();
  }
  nlohmann::json summary() { return fleet_.finish("far enough"); }

 private:
  const robot::Knowledge& knows(RobotId id) const { return fleet_.knowledge(id); }

  void note() {
    const SimTime now = fleet_.now();
    if (now.s() <= kSkewed_s + kContact_s) return;  // what was heard before does not count
    if (!contact_s && std::ranges::any_of(fleet_.mission().fleet, [&](const auto& other) {
          return other.id != robot_ && knows(robot_).in_contact(other.id);
        })) {
      contact_s = now.s();
    }
    if (contact_s) note_meeting(now);
  }

  /// By the world's time, which is the fleet's.
  void note_meeting(SimTime now) {
    const auto* word =
        knows(kStation).meeting(kStation, kExplorer, mission::MeetingKind::kAcknowledgement);
    const auto* heard =
        knows(kExplorer).meeting(kStation, kExplorer, mission::MeetingKind::kAcknowledgement);
    if (word && heard && word->header.version() == heard->header.version() &&
        word->body.meeting != number_) {
      number_ = word->body.meeting;  // who agrees anew has met
      rung_ = word->body.ladder.front();
      ++agreed;
    }
    if (!rung_) return;
    const bool met = now >= rung_->from && knows(kStation).in_contact(kExplorer);
    if (!met && now > rung_->until) missed.push_back(static_cast<int>(rung_->from.s()));
    if (met || now > rung_->until) rung_.reset();
  }

  RobotId robot_;
  test::OpenFleet fleet_;
  MeetingId number_{};
  std::optional<mission::Rung> rung_;  ///< agreed, and not yet met
};

}  // namespace

TEST_CASE("a clock off by a minute is right after its first contact, and no meeting is missed") {
  const auto [robot, by_s] =
      GENERATE(table<std::uint32_t, double>({{2, 60}, {2, -60}, {1, 60}, {3, -60}}));
  CAPTURE(robot, by_s);
  Flight flight(RobotId{robot}, by_s);
  CHECK(flight.contact_s);
  CHECK(flight.agreed >= 2);
  CHECK(flight.missed == std::vector<int>{});
  CHECK(flight.spread_s() < 1);
  CHECK(flight.summary().at("collisions") == 0);
}
