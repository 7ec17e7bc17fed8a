#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "common/core/log.h"
#include "common/mission/mission.h"
#include "tests/fleet/open_fleet.h"

using namespace muster;

namespace {

/// A flight in memory, until all have landed.
class Flown {
 public:
  Flown(const std::string& mission, std::uint64_t seed)
      : fleet_(mission::Mission::load(std::string(MUSTER_SOURCE_DIR) + "/tests/missions/" + mission,
                                      {"seed=" + std::to_string(seed)})) {
    spdlog::set_level(spdlog::level::warn);
    constexpr int kStay = 40;  // ticks: a rover that only turns stands for less
    std::optional<std::string> end;
    for (int home = 0; !end && home < kStay;) {
      end = fleet_.tick();
      home = after_script() && all_home(mission::VehicleState::kLanded) ? home + 1 : 0;
    }
    summary = fleet_.finish(end.value_or("all have landed"));
  }

  /// Everybody who lives stands where it started, or touches down there (what a robot last heard of
  /// itself is a tick old).
  bool all_home(mission::VehicleState least = mission::VehicleState::kLanding) const {
    return std::ranges::all_of(fleet_.robots(),
                               [&](const auto& r) { return is_home(*r.second, least); });
  }

  const robot::Knowledge& station() const { return fleet_.knowledge(fleet_.mission().station()); }

  nlohmann::json summary;

 private:
  bool after_script() {
    return std::ranges::all_of(fleet_.mission().script, [&](const auto& e) {
      return e.at + Duration::from_s(5) < fleet_.now();
    });
  }
  bool is_home(const robot::Robot& r, mission::VehicleState least) const {
    const mission::RobotConfig& config = fleet_.mission().robot(r.id());
    const Vec3 off = r.knowledge().position() - config.start.p;
    const mission::Odometry& o = r.knowledge().odometry();
    const bool down = config.vehicle.ground
                          ? o.velocity_mps.norm() < 0.05
                          : o.state == least || o.state == mission::VehicleState::kLanded;
    return down && std::hypot(off.x(), off.y()) <= 1.5;  // as the referee counts
  }

  test::OpenFleet fleet_;
};

}  // namespace

TEST_CASE("with the radio silent and a dead robot in the way nothing touches, and all come home") {
  for (const std::uint64_t seed : {1, 2}) {
    CAPTURE(seed);
    const Flown flown("pagoda_silent.yaml", seed);
    CHECK(flown.summary.at("collisions") == 0);
    CHECK(flown.summary.at("robots_lost").size() == 1);
    CHECK(flown.all_home());
  }
}

TEST_CASE("robots that cannot hear each other while still close together do not touch") {
  for (const std::uint64_t seed : {1, 2}) {
    CAPTURE(seed);
    const Flown flown("pagoda_deaf.yaml", seed);
    CHECK(flown.summary.at("collisions") == 0);
    CHECK(flown.all_home());
  }
}

TEST_CASE("an abort brings everybody home, and the station keeps what was found") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    const Flown flown("pagoda_abort.yaml", seed);
    CHECK(flown.summary.at("collisions") == 0);
    CHECK(flown.all_home());
    CHECK(flown.summary.at("features_delivered") > 0);
    CHECK_FALSE(flown.station().results().empty());
    // Aborted at 60 s; the explorer tells those out of hearing for 180 s at most.
    REQUIRE_FALSE(flown.summary.at("home_time_s").is_null());
    CHECK(flown.summary.at("home_time_s") < 60 + 180 + 60);
  }
}
