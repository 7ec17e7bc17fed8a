#include "common/nav/trajectory.h"

#include <algorithm>
#include <cmath>

#include "common/core/error.h"

namespace muster::nav {

Trajectory::Trajectory(std::vector<State> states) : states_(std::move(states)) {
  for (std::size_t i = 1; i < states_.size(); ++i) MUSTER_CHECK(states_[i - 1].t < states_[i].t);
}

SimTime Trajectory::start() const {
  MUSTER_CHECK(!empty());
  return states_.front().t;
}

SimTime Trajectory::end() const {
  MUSTER_CHECK(!empty());
  return states_.back().t;
}

State Trajectory::at(SimTime t) const {
  MUSTER_CHECK(!empty());
  if (t <= states_.front().t)
    return {t, states_.front().p, states_.front().v_mps, states_.front().yaw_rad};
  if (t >= states_.back().t) return {t, states_.back().p, Vec3::Zero(), states_.back().yaw_rad};
  const auto next = std::upper_bound(states_.begin(), states_.end(), t,
                                     [](SimTime value, const State& s) { return value < s.t; });
  const State &b = *next, &a = *(next - 1);
  const double h = (b.t - a.t).s(), u = (t - a.t).s() / h;
  const double u2 = u * u, u3 = u2 * u;
  State s;
  s.t = t;
  s.p = (2 * u3 - 3 * u2 + 1) * a.p + (u3 - 2 * u2 + u) * h * a.v_mps + (3 * u2 - 2 * u3) * b.p +
        (u3 - u2) * h * b.v_mps;
  s.v_mps =
      6 * (u2 - u) / h * (a.p - b.p) + (3 * u2 - 4 * u + 1) * a.v_mps + (3 * u2 - 2 * u) * b.v_mps;
  s.yaw_rad = wrap_angle(a.yaw_rad + u * wrap_angle(b.yaw_rad - a.yaw_rad));
  return s;
}

Trajectory stop(const State& now, const Limits& limits) {
  State halt = now;
  halt.v_mps = Vec3::Zero();
  const double speed = now.v_mps.norm();
  // A whole number of microseconds, rounded up: the deceleration never exceeds the limit.
  const auto us = static_cast<std::int64_t>(std::ceil(speed / limits.accel_mps2 * 1e6));
  if (us == 0) return Trajectory({halt});
  const Duration h{us};
  halt.t = now.t + h;
  halt.p = now.p + now.v_mps * (h.s() / 2);
  return Trajectory({now, halt});
}

Vec3 Mover::at(SimTime t) const {
  const auto next = std::upper_bound(announced.begin(), announced.end(), t,
                                     [](SimTime value, const State& s) { return value < s.t; });
  if (next == announced.begin()) return announced.front().p;
  if (next == announced.end()) return announced.back().p;
  const State &a = *(next - 1), &b = *next;
  return a.p + (b.p - a.p) * ((t - a.t).s() / (b.t - a.t).s());
}

}  // namespace muster::nav
