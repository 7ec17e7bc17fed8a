#include "common/nav/headway.h"

#include <algorithm>
#include <cmath>

namespace muster::nav {
namespace {

constexpr Duration kStep{50'000};
constexpr Duration kFlank{100'000};  // an announced velocity is taken over this long

Vec3 announced_at(const Mover& m, SimTime t) {
  const auto& s = m.announced;
  const auto next = std::upper_bound(s.begin(), s.end(), t,
                                     [](SimTime value, const State& a) { return value < a.t; });
  if (next == s.begin()) return s.front().p;
  if (next == s.end()) return s.back().p;
  const State &a = *(next - 1), &b = *next;
  return a.p + (b.p - a.p) * ((t - a.t).s() / (b.t - a.t).s());
}

}  // namespace

double least_gap(const Trajectory& own, double radius_m, const Mover& other, SimTime from,
                 Duration span) {
  double least = std::numeric_limits<double>::infinity();
  for (SimTime t = from; t <= from + span; t = t + kStep) {
    least = std::min(least, (own.at(t).p - announced_at(other, t)).norm());
  }
  return least - radius_m - other.radius_m;
}

double speed(const Mover& mover, SimTime now) {
  return (announced_at(mover, now + kFlank) - announced_at(mover, now)).norm() / kFlank.s();
}

Mover braking(const Mover& mover, SimTime now, const Limits& limits) {
  const Vec3 p = announced_at(mover, now);
  const Vec3 v = (announced_at(mover, now + kFlank) - p) / kFlank.s();
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
