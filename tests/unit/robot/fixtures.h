#pragma once

#include "common/mission/mission.h"
#include "common/robot/knowledge.h"
#include "common/robot/strategy.h"

namespace muster::robot {

/// An open field with a station (0), an explorer (1) and an inspector (2), and one box.
inline mission::Mission small_mission() {
  mission::Mission m;
  m.name = "small";
  m.file = "small.yaml";
  m.hull = Box::from_corners({-15, -15, 0}, {15, 15, 8});
  m.boxes = {Box::from_corners({2, -4, 0.3}, {10, 4, 6})};
  m.standing.place = {-5, 0, 0.5};
  m.standing.t0 = Duration::from_s(300);
  m.standing.period = Duration::from_s(120);
  m.standing.window = Duration::from_s(30);
  const mission::Role roles[] = {mission::Role::kStation, mission::Role::kExplorer,
                                 mission::Role::kInspector};
  for (std::uint32_t i = 0; i < 3; ++i) {
    mission::RobotConfig r;
    r.id = RobotId{i};
    r.role = roles[i];
    r.vehicle.ground = i == 0;
    r.start.p = {-5 + 1.5 * i, 0, i == 0 ? 0.5 : 1.0};
    m.fleet.push_back(r);
  }
  return m;
}

/// Stays where it is.
struct Idle : Strategy {
  Intent decide(Knowledge&, const Progress&) override { return {}; }
};

/// A beacon of `of`, heard by `by` now: contact, without any exchange of records.
inline void hear(Knowledge& by, const Knowledge& of) {
  mission::Beacon b;
  b.envelope.src = of.self();
  b.envelope.sent = b.mission_time = by.now();
  b.epoch = of.epoch();
  b.pose = of.odometry().pose;
  b.radius_m = 0.25f;
  by.hear(b);
}

/// Everything `from` holds of a class arrives at `to`.
inline void pass(const Knowledge& from, Knowledge& to, store::RecordClass cls) {
  static std::uint64_t n = 0;
  for (const store::Record* r : from.store().all(cls)) to.receive(from.self(), ++n, *r);
}

}  // namespace muster::robot
