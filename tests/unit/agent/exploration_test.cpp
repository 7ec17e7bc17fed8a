#include "agent/strategy/exploration.h"

#include <catch2/catch.hpp>
#include <limits>
#include <numbers>

#include "tests/unit/agent/place.h"

using namespace muster;
using namespace muster::agent;
using robot::Knowledge;

namespace {

constexpr RegionId kWest{0}, kEast{1};

/// Two boxes side by side and a cliff through both, all of it known.
struct Site {
  Site() {
    be_at(k, 1, {-1, -3, 2});
    reveal(k, {-5, -6, 0.3}, {5, 5, 4.5}, [](const Vec3& p) { return p.y() > 0; });
  }
  static mission::Sightings look(double x_m, const std::vector<Vec3>& at = {}) {
    mission::Sightings s;
    s.sensor = {{x_m, -2.5, 2}, std::numbers::pi / 2};
    for (const Vec3& p : at) s.seen.push_back({p, 0, 0, 0});
    return s;
  }
  /// What is still owed to `region` by who begins with it now.
  double owed_m2(RegionId region) {
    Exploration exploration(k, region);
    return owed_m2(exploration);
  }
  double owed_m2(Exploration& exploration) {
    mission::Scan scan;
    scan.sensor.p = k.position();
    exploration.on_scan(scan);
    std::vector<mission::PlanningTime> planning;
    exploration.next(k, {}, std::numeric_limits<double>::infinity(), {}, planning);
    return exploration.targets().owed_surface_m2();
  }

  /// Looks at the cliff from near and far, until nothing large is owed.
  void survey(Exploration& exploration) {
    for (int i = 0; i < 100; ++i) {
      mission::Sightings s = look(-5 + 0.5 * (i % 10));
      const int nearer = i / 10 % 5, higher = i / 20;
      s.sensor.p.y() = -1 - 0.5 * nearer;
      s.sensor.p.z() = 0.8 + 0.8 * higher;
      exploration.on_look(k, s);
    }
    for (int i = 0; i < 10 && !exploration.surveyed(); ++i) {
      be_at(k, k.now().s() + 5, {-1, -3, 2});
      owed_m2(exploration);
    }
  }

  mission::Mission mission = two_boxes();
  Knowledge k{mission, RobotId{1}, 1};

 private:
  static mission::Mission two_boxes() {
    mission::Mission m = robot::small_mission();
    m.boxes = {Box::from_corners({-4, -4, 0.3}, {0, 4, 4}),
               Box::from_corners({0, -4, 0.3}, {4, 4, 4})};
    return m;
  }
};

}  // namespace

TEST_CASE("an exploration begun again owes what the one before owed") {
  Site site;
  const double all_m2 = site.owed_m2(kWest);
  Exploration before(site.k, kWest);
  const auto look = [&](const mission::Sightings& s) {
    site.k.keep_look(kWest, s);
    before.on_look(site.k, s);
  };
  for (int i = 0; i < 40; ++i) look(Site::look(-2.5 + 0.01 * i));
  look(Site::look(-2, {{-2, 0, 2}}));
  const double left_m2 = site.owed_m2(before);
  CHECK(left_m2 < 0.8 * all_m2);
  CHECK(left_m2 > 0.1 * all_m2);
  CHECK(site.owed_m2(kWest) == left_m2);
}

TEST_CASE("a look on behalf of another region counts for what it showed of this one") {
  Site site;
  const double all_m2 = site.owed_m2(kEast);
  for (int i = 0; i < 2; ++i) site.k.keep_look(kWest, Site::look(-0.5, {{1, 0, 2}}));
  CHECK(site.owed_m2(kEast) < all_m2);
}

TEST_CASE("a look on nobody's behalf counts where it sighted nothing that would be lost") {
  Site site;
  const double all_m2 = site.owed_m2(kWest);
  for (int i = 0; i < 2; ++i) site.k.keep_look(kNoRegion, Site::look(-2, {{-2, 0, 2}}));
  CHECK(site.owed_m2(kWest) == all_m2);
  for (int i = 0; i < 2; ++i) site.k.keep_look(kNoRegion, Site::look(-2));
  CHECK(site.owed_m2(kWest) < all_m2);
}

TEST_CASE("looks that another told of count, also when word of them comes late") {
  Site site;
  const double all_m2 = site.owed_m2(kWest);
  Exploration begun(site.k, kWest);
  const Pose there = Site::look(-2).sensor;
  const auto owed_there_m2 = [&] {
    site.owed_m2(begun);
    return begun.targets().worth(there).owed_m2;
  };
  const double before_m2 = owed_there_m2();
  Knowledge other(site.mission, RobotId{2}, 1);
  mission::Status told;
  told.kind = mission::StatusKind::kLooks;
  told.looks = {there, there};
  other.publish(store::RecordClass::kRequest, 7, told);
  robot::pass(other, site.k, store::RecordClass::kRequest);
  CHECK(owed_there_m2() < 0.5 * before_m2);
  CHECK(site.owed_m2(kWest) < all_m2);
}

TEST_CASE(
    "when a box is surveyed, the more was found there, the smaller is what is still looked at") {
  Site site;
  // Something of one voxel: less than anybody would look at.
  reveal(site.k, {-5, -6, 0.3}, {5, 5, 4.5},
         [](const Vec3& p) { return p.y() > 0 || (p - Vec3(-2.1, -1.1, 2.1)).norm() < 0.1; });
  const auto least = [&](bool surveyed) {
    Exploration exploration(site.k, kWest);
    if (surveyed) site.survey(exploration);
    REQUIRE(exploration.surveyed() == surveyed);
    for (int i = 0; i < 2; ++i) {
      be_at(site.k, site.k.now().s() + 5, {-1, -3, 2});
      site.owed_m2(exploration);
    }
    for (const map::Refused& r : exploration.targets().refused()) {
      if (r.reason.starts_with("surface: looks promise")) return r.reason;
    }
    return std::string();
  };
  const std::string cursory = "surface: looks promise less than 0.30 m²";
  CHECK(least(false) == cursory);
  const std::string before = least(true);
  CHECK(before < cursory);
  for (std::uint64_t i = 1; i <= 20; ++i)
    site.k.publish(store::RecordClass::kArea, i, area_at({-2, 0, 2}, {-2, -3, 2}));
  CHECK(least(false) == cursory);
  CHECK(least(true) < before);
  CHECK(least(true) == "surface: looks promise less than 0.12 m²");
}
