#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <numbers>

#include "common/core/random.h"
#include "common/robot/executive.h"
#include "tests/unit/map/said.h"
#include "tests/unit/robot/fixtures.h"

using namespace muster;
using robot::Executive;
using robot::Intent;
using robot::Knowledge;

namespace {

mission::Mission fleet_mission(int robots) {
  mission::Mission m = robot::small_mission();
  m.fleet.resize(1);
  for (int i = 1; i <= robots; ++i) {
    mission::RobotConfig r;
    r.id = RobotId{static_cast<std::uint32_t>(i)};
    r.role = i % 3 == 1 ? mission::Role::kExplorer : mission::Role::kInspector;
    m.fleet.push_back(r);
  }
  return m;
}

/// One robot that flies what its executive says, to the millimetre, in space that it knows free.
class Flyer {
 public:
  Flyer(const mission::Mission& m, RobotId id, const Vec3& start)
      : knowledge_(m, id, 1), executive_(m, id), p_(start) {}

  Knowledge& knowledge() { return knowledge_; }
  const Vec3& p() const { return p_; }
  bool arrived() const { return executive_.progress().state == robot::Progress::State::kArrived; }
  void go(const Vec3& goal) {
    intent_.kind = Intent::Kind::kGo;
    intent_.goal.p = goal;
    intent_.tolerance_m = 0.3;
    intent_.activity = mission::Activity::kTravelling;
  }

  void look_from(const Pose& pose, mission::Activity activity) {
    go(pose.p);
    intent_.goal = pose;
    intent_.use_yaw = true;
    intent_.activity = activity;
  }

  void hover() { intent_ = {}; }
  const Executive& executive() const { return executive_; }
  /// Flies no further what it was told.
  void stop() { flown_ = {}; }

  void step(SimTime now, const std::vector<mission::Beacon>& heard) {
    knowledge_.begin(now);
    mission::Odometry o;
    const nav::State s = state(now);
    o.pose = {s.p, s.yaw_rad};
    o.velocity_mps = s.v_mps;
    o.state = mission::VehicleState::kMoving;
    knowledge_.observe(o);
    p_ = s.p;
    yaw_rad_ = s.yaw_rad;
    for (const mission::Beacon& b : heard) {
      if (b.envelope.src != knowledge_.self()) knowledge_.hear(b);
    }
    if (executive_.step(knowledge_, intent_).trajectory) flown_ = executive_.trajectory();
  }

  mission::Beacon beacon(SimTime now) const {
    mission::Beacon b;
    b.envelope.src = knowledge_.self();
    b.envelope.sent = b.mission_time = now;
    b.epoch = 1;
    b.pose = knowledge_.odometry().pose;
    b.velocity_mps = knowledge_.odometry().velocity_mps;
    b.activity = intent_.activity;
    b.radius_m = 0.25f;
    b.trajectory = executive_.announcement(now);
    return b;
  }

 private:
  nav::State state(SimTime t) const {
    return flown_.empty() ? nav::State{t, p_, Vec3::Zero(), yaw_rad_} : flown_.at(t);
  }

  Knowledge knowledge_;
  Executive executive_;
  Intent intent_;
  nav::Trajectory flown_;
  Vec3 p_;
  double yaw_rad_ = 0;
};

/// An empty hall of 12.8 × 12.8 × 3.2 m that everybody knows, where `known` says so.
class Hall {
 public:
  explicit Hall(
      const std::vector<Vec3>& starts,
      const std::function<bool(const Vec3&)>& known = [](const Vec3&) { return true; })
      : mission_(fleet_mission(static_cast<int>(starts.size()))) {
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const RobotId id{static_cast<std::uint32_t>(i + 1)};
      flyers_.push_back(std::make_unique<Flyer>(mission_, id, starts[i]));
      for (int block = 0; block < 16; ++block) {
        const map::BlockKey key{block % 4 - 2, block / 4 - 2, 0};
        map::VoxelMap& map = flyers_.back()->knowledge().map();
        std::vector<map::Voxel> voxels;
        for (int voxel = 0; voxel < map::kBlockVoxels; ++voxel) {
          const Vec3 p = map.center(map::voxel_in(key, voxel));
          voxels.push_back(known(p) ? map::Voxel::kFree : map::Voxel::kUnknown);
        }
        map.merge(RobotId{99}, map::said(key, voxels));
      }
    }
  }
  double hears_m = 5;

  std::size_t size() const { return flyers_.size(); }
  Flyer& operator[](std::size_t i) { return *flyers_[i]; }

  /// No process gets any time.
  void pause(double span_s) { now_ = now_ + Duration::from_s(span_s); }
  /// Returns the least gap between any two bodies over this span.
  double run(double span_s) {
    double least_m = 1e9;
    for (const SimTime end = now_ + Duration::from_s(span_s); now_ < end; now_ = now_ + kTick) {
      std::vector<mission::Beacon> said;
      for (auto& f : flyers_) {
        std::vector<mission::Beacon> near;
        for (const mission::Beacon& b : heard_) {
          if ((b.pose.p - f->p()).norm() < hears_m) near.push_back(b);
        }
        f->step(now_, near);
        said.push_back(f->beacon(now_));
      }
      heard_ = std::move(said);  // on the air for a tick
      for (std::size_t i = 0; i < flyers_.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
          least_m = std::min(least_m, (flyers_[i]->p() - flyers_[j]->p()).norm() - 0.5);
        }
      }
    }
    return least_m;
  }

 private:
  mission::Mission mission_;
  std::vector<std::unique_ptr<Flyer>> flyers_;
  std::vector<mission::Beacon> heard_;
  SimTime now_;
};

}  // namespace

TEST_CASE("who hovers below one that falls silent is out from under it before it can land there") {
  Hall hall({Vec3(0, 0, 1), Vec3(0.1, 0, 2.4)});
  hall.run(1);
  CHECK((hall[0].p() - Vec3(0, 0, 1)).norm() < 0.01);
  const Vec3 above = hall[1].p();
  hall.hears_m = 0;
  for (double silent_s = 0.1; silent_s < 4; silent_s += 0.1) {
    hall.run(0.1);
    const Vec3 falling = above - Vec3(0, 0, 0.8 * std::max(0.0, silent_s - 1));  // as vehicles do
    CAPTURE(silent_s);
    CHECK((hall[0].p() - falling).norm() > 0.55);
  }
}

TEST_CASE("who follows keeps off when the one in front brakes, whoever has the right of way") {
  const bool first = GENERATE(true, false);
  const double behind_m = GENERATE(0.6, 0.7, 0.9, 1.2, 1.6, 2.2);
  const Vec3 front(-4 + behind_m, 0, 1.5), back(-4, 0, 1.5);
  Hall hall({first ? front : back, first ? back : front});
  for (std::size_t i = 0; i < 2; ++i) hall[i].go(Vec3(5.5, 0, 1.5));
  Flyer& leader = hall[first ? 0 : 1];
  CHECK(hall.run(1.7) > 0);
  leader.hover();
  hall.hears_m = 0;  // a beacon is lost
  CHECK(hall.run(0.2) > 0);
  hall.hears_m = 5;
  CHECK(hall.run(5) > 0);
}

TEST_CASE("who does not hear a neighbour in sight stands until it does, or for a minute") {
  const bool again = GENERATE(true, false);
  Hall hall({Vec3(-4, 0, 1.5), Vec3(-4, 2, 1.5)});
  hall.run(1);
  hall.hears_m = 0;
  hall.run(3);
  hall[0].go(Vec3(5, 0, 1.5));
  hall.run(30);
  CHECK((hall[0].p() - Vec3(-4, 0, 1.5)).norm() < 0.05);
  hall.hears_m = again ? 5 : 0;
  hall.run(again ? 8 : 38);
  CHECK(hall[0].arrived());
}

TEST_CASE("who flew away from its neighbour does not wait for it") {
  Hall hall({Vec3(-4, 0, 1.5), Vec3(-4, 2, 1.5)});
  hall[0].go(Vec3(5, 0, 1.5));
  hall.run(8);
  CHECK(hall[0].arrived());
  hall[0].go(Vec3(5, 5, 1.5));
  hall.run(6);
  CHECK(hall[0].arrived());
}

TEST_CASE("who explores turns its camera on the way while the radio works, and nobody else does") {
  const bool explores = GENERATE(true, false), hears = GENERATE(true, false);
  CAPTURE(explores, hears);
  Hall hall({Vec3(0, -1.5, 1.5), Vec3(4, 0, 1.5)});
  hall.hears_m = hears ? 5 : 0;
  hall.run(1);
  hall[0].look_from({{0, 1.5, 1.5}, -std::numbers::pi / 2},
                    explores ? mission::Activity::kExploring : mission::Activity::kTravelling);
  hall.run(3.6);
  CHECK(hall[0].arrived() == (explores && hears));
  hall.run(5);
  CHECK(hall[0].arrived());
}

TEST_CASE("robots that go home to neighbouring places never touch on the way") {
  Random random(1, kNoRobot, "home");
  for (int i = 0; i < 150; ++i) {
    CAPTURE(i);
    const auto start = [&](double x) {
      return Vec3(x + random.uniform(-1.3, 1.3), random.uniform(-6, -2), random.uniform(1, 2.5));
    };
    Hall hall({start(-4.5), start(-1.5), start(1.5), start(4.5)});
    const Vec3 homes[] = {{0, 4.7, 1}, {-1.3, 4.7, 1}, {1.3, 4.7, 1}, {0, 6, 1}};
    for (std::size_t r = 0; r < hall.size(); ++r) {
      hall[r].go(homes[r]);
      REQUIRE(hall.run(random.uniform(0, 1.5)) > 0);
    }
    CHECK(hall.run(12) > 0);
  }
}

TEST_CASE("robots that cross, meet and follow each other never touch, and all get on") {
  const std::uint64_t seed = GENERATE(range(1, 13));
  Random random(seed, kNoRobot, "right of way");
  const auto somewhere = [&] {
    return Vec3(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(1, 2.2));
  };
  Hall hall({{-4, -4, 1}, {4, 4, 1}, {-4, 4, 2}, {4, -4, 2}, {0, 0, 1.5}});
  std::vector<int> arrivals(hall.size());
  for (std::size_t i = 0; i < hall.size(); ++i) hall[i].go(somewhere());
  for (int i = 0; i < 600; ++i) {
    REQUIRE(hall.run(0.1) > 0);
    for (std::size_t r = 0; r < hall.size(); ++r) {
      if (!hall[r].arrived()) continue;
      ++arrivals[r];
      hall[r].go(somewhere());
    }
  }
  for (const int n : arrivals) CHECK(n >= 2);
}

TEST_CASE("a robot that got no time for more than a second forgets its flight and sets out again") {
  const Vec3 goal(5, 0, 1.5);
  for (const double pause_s : {0.8, 1.5}) {
    CAPTURE(pause_s);
    Hall hall({Vec3(-4, 0, 1.5)});
    hall[0].go(goal);
    hall.run(1);
    const auto before = hall[0].executive().trajectory().end();
    hall.pause(pause_s);
    if (pause_s > 1) hall[0].stop();  // as the vehicle does meanwhile (RULES)
    hall.run(0.1);
    const bool goes_on = hall[0].executive().trajectory().end() == before;
    CHECK(goes_on == (pause_s < 1));
    hall.run(12);
    CHECK((hall[0].p() - goal).norm() < 0.5);
  }
}

TEST_CASE("who came down deep into what nobody knows rises before it flies anywhere") {
  const Vec3 down(-4.1, 3.1, 0.5), goal(3, 0, 2.5);
  Hall hall({down}, [&](const Vec3& p) {
    const bool swept = (p - down).head<2>().norm() < 0.25 && p.z() > 0.2;
    return p.z() > 1.6 || swept;
  });
  REQUIRE_FALSE(hall[0].knowledge().map().traversable(down));
  hall[0].go(goal);
  hall.run(20);
  CHECK((hall[0].p() - goal).norm() < 0.5);
}

TEST_CASE(
    "a rover pressed by what others tell of goes back the way it came, and never through it") {
  const mission::Mission m = fleet_mission(0);
  const double z = m.fleet[0].start.p.z();
  const Vec3 start(-4.1, 2.1, z), here(-2.056, 3.375, z), post(-2.1, 3.1, 0.7), goal(-4.1, 1.1, z);
  Flyer rover(m, m.fleet[0].id, start);
  map::VoxelMap& map = rover.knowledge().map();
  const auto told = [&](bool with_post) {
    for (int block = 0; block < 16; ++block) {
      const map::BlockKey key{block % 4 - 2, block / 4 - 2, 0};
      std::vector<map::Voxel> voxels(map::kBlockVoxels, map::Voxel::kFree);
      for (int voxel = 0; voxel < map::kBlockVoxels; ++voxel) {
        const map::VoxelKey k = map::voxel_in(key, voxel);
        const bool wall = map.center(k).y() > 3.8;
        if (wall || (with_post && k == map.key(post)))
          voxels[static_cast<std::size_t>(voxel)] = map::Voxel::kOccupied;
      }
      map.merge(RobotId{99}, map::said(key, voxels));
    }
  };
  told(false);
  rover.go(here);
  SimTime now;
  std::vector<Vec3> came;
  const auto drive = [&](int ticks, const auto& each) {
    for (int tick = 0; tick < ticks; ++tick, now = now + kTick) {
      rover.step(now, {});
      each(rover.p());
    }
  };
  drive(100, [&](const Vec3& p) { came.push_back(p); });
  REQUIRE((rover.p() - here).norm() < 0.35);
  told(true);
  REQUIRE_FALSE(map.traversable(rover.p()));
  rover.go(goal);
  bool pressed = true;
  drive(300, [&](const Vec3& p) {
    pressed = pressed && !map.traversable(p);
    if (!pressed) return;
    CHECK(std::ranges::any_of(came, [&](const Vec3& c) { return (c - p).norm() < 0.12; }));
  });
  CHECK((rover.p() - goal).norm() < 0.5);
  CHECK(map.at(post) == map::Voxel::kOccupied);  // believed all the time
}
