#include "common/nav/headway.h"

#include <algorithm>
#include <limits>

namespace muster::nav {
namespace {

constexpr Duration kStep{50'000};
constexpr Duration kFlank{100'000};  // an announced velocity is taken over this long

}  // namespace

double least_gap(const Trajectory& own, double radius_m, const Mover& other, SimTime from,
                 Duration span) {
  double least = std::numeric_limits<double>::infinity();
  for (SimTime t = from; t <= from + span; t = t + kStep) {
    least = std::min(least, (own.at(t).p - other.at(t)).norm());
  }
  return least - radius_m - other.radius_m;
}

double speed(const Mover& mover, SimTime now) {
  return (mover.at(now + kFlank) - mover.at(now)).norm() / kFlank.s();
}

Mover braking(const Mover& mover, SimTime now, const Limits& limits) {
  const Vec3 p = mover.at(now);
  const Vec3 v = (mover.at(now + kFlank) - p) / kFlank.s();
  Mover result{mover.robot, mover.radius_m, {}};
  const Trajectory halt = stop({now, p, v, 0}, limits);
  for (SimTime t = now; t < halt.end(); t = t + kFlank) result.announced.push_back(halt.at(t));
  result.announced.push_back(halt.at(halt.end()));
  return result;
}

Trajectory braking_late(const Trajectory& own, SimTime now, Duration reaction,
                        const Limits& limits) {
  std::vector<State> states;
  for (SimTime t = now; t < now + reaction; t = t + kStep) states.push_back(own.at(t));
  const Trajectory halt = stop(own.at(now + reaction), limits);
  states.insert(states.end(), halt.states().begin(), halt.states().end());
  return Trajectory(std::move(states));
}

}  // namespace muster::nav
