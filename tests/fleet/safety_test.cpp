#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "common/core/log.h"
#include "common/mission/mission.h"
#include "common/robot/robot.h"
#include "deploy/muster/memory_fleet.h"

using namespace muster;

namespace {

/// A flight in memory whose robots can be looked into.
class Flown {
 public:
  Flown(const std::string& mission, std::uint64_t seed)
      : mission_(
            mission::Mission::load(std::string(MUSTER_SOURCE_DIR) + "/tests/missions/" + mission,
                                   {"seed=" + std::to_string(seed)})),
        fleet_(mission_, world::Scene::load(mission_),
               [this](const mission::Mission& m, RobotId id, std::uint64_t epoch) {
                 auto process = command::make_process(m, id, epoch);
                 robots_[id] = dynamic_cast<const robot::Robot*>(process.get());
                 return process;
               },
               {}) {
    spdlog::set_level(spdlog::level::warn);
    constexpr int kStay = 40;  // ticks: a rover that only turns stands for less
    for (int home = 0; !end_ && home < kStay;) {
      end_ = fleet_.tick();
      for (const mission::ScriptedEvent& e : mission_.script) {
        if (e.verb == "kill" && e.at < fleet_.flight().now()) robots_.erase(e.robot);
      }
      home = after_script() && all_home(mission::VehicleState::kLanded) ? home + 1 : 0;
    }
    summary = fleet_.finish(end_.value_or("all have landed"));
  }

  /// Everybody who lives stands where it started, or touches down there (what a robot last heard of
  /// itself is a tick old).
  bool all_home(mission::VehicleState least = mission::VehicleState::kLanding) const {
    return std::all_of(robots_.begin(), robots_.end(),
                       [&](const auto& r) { return is_home(*r.second, least); });
  }

  const robot::Knowledge& station() const { return robots_.at(mission_.station())->knowledge(); }

  nlohmann::json summary;

 private:
  bool after_script() {
    return std::all_of(mission_.script.begin(), mission_.script.end(), [&](const auto& e) {
      return e.at + Duration::from_s(5) < fleet_.flight().now();
    });
  }
  bool is_home(const robot::Robot& r, mission::VehicleState least) const {
    const mission::RobotConfig& config = mission_.robot(r.id());
    const Vec3 off = r.knowledge().position() - config.start.p;
    const mission::Odometry& o = r.knowledge().odometry();
    const bool down = config.vehicle.ground
                          ? o.velocity_mps.norm() < 0.05
                          : o.state == least || o.state == mission::VehicleState::kLanded;
    return down && std::hypot(off.x(), off.y()) <= 1.5;  // as the referee counts
  }

  mission::Mission mission_;
  std::map<RobotId, const robot::Robot*> robots_;
  command::MemoryFleet fleet_;
  std::optional<std::string> end_;
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
