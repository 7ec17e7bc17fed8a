#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "common/nav/course.h"
#include "common/nav/trajectory.h"

namespace muster::nav {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kAligned =
    20 * kDegree;  ///< a velocity further off the path is braked away first,
constexpr double kSwing =
    80 * kDegree;                 ///< unless it is so slow (in a bend, say) that it swings in
constexpr double kSwing_m = 0.2;  ///< within this of the path
constexpr double kLookingAway =
    65 * kDegree;                    ///< so is a velocity that the camera does not look along
constexpr double kReaction_s = 0.2;  ///< sensing and deciding, before braking begins
constexpr double kStill_mps = 1e-6;
constexpr double kAtRest_mps =
    2e-3;  ///< what rounding leaves of a stop; a bend begun at it would never end
constexpr double kApart_m = 1e-3;

/// Speed from which the vehicle can react and stop within `see_m`.
double sight_speed(double see_m, double accel) {
  return accel *
         (std::sqrt(kReaction_s * kReaction_s + 2 * std::max(see_m, 0.0) / accel) - kReaction_s);
}

/// How the speed may change along straights.
struct Rates {
  double accel = 0, brake = 0;
};

/// Speeds at the nodes: as fast as pieces, stops and the way from and to rest allow. Empty when the
/// first speed is too fast to stay on course.
std::vector<double> node_speeds(const Course& course, double first_mps, Rates rates) {
  const std::size_t n = course.pieces.size();
  std::vector<double> cap(n), speed(n + 1, 0);
  double s = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const auto& piece = course.pieces[k];
    // Too fast now for a soft limit: allowed as long as it brakes.
    const double braking = std::sqrt(std::max(0.0, first_mps * first_mps - 2 * rates.brake * s));
    cap[k] = std::min(piece.hard_mps, std::max(piece.soft_mps, braking));
    if (!piece.bend) s += piece.length_m;
  }
  for (std::size_t k = 1; k < n; ++k) {
    const auto& node = course.nodes[k];
    speed[k] = node.yaw_in_rad != node.yaw_out_rad ? 0 : std::min(cap[k - 1], cap[k]);
  }
  speed[0] = first_mps;
  const auto reach = [&](std::size_t k, double v, double rate) {
    const auto& piece = course.pieces[k];
    return piece.bend ? v : std::sqrt(v * v + 2 * rate * piece.length_m);
  };
  for (std::size_t k = n; k-- > 0;) {
    const double most = reach(k, speed[k + 1], rates.brake);
    if (k == 0 && first_mps > std::min(most, cap[0]) + kStill_mps) return {};
    speed[k] = std::min(speed[k], most);
  }
  for (std::size_t k = 0; k < n; ++k)
    speed[k + 1] = std::min(speed[k + 1], reach(k, speed[k], rates.accel));
  return speed;
}

/// Appends states so that every one follows from the last by a whole number of microseconds of
/// constant acceleration.
class Writer {
 public:
  Writer(const State& first, double yaw_rate) : yaw_rate_(yaw_rate) { states_.push_back(first); }

  /// Rounded up to the microsecond, so that no limit is exceeded; the position follows from the
  /// rounded time.
  void accelerate_to(const Vec3& v, double seconds, double yaw) {
    const auto us = static_cast<std::int64_t>(std::ceil(seconds * 1e6 - 1e-3));
    if (us <= 0) return;
    State next = states_.back();
    const Duration h{us};
    next.t = next.t + h;
    next.p += (next.v_mps + v) * (h.s() / 2);
    next.v_mps = v;
    const double most = yaw_rate_ * h.s();
    next.yaw_rad += std::clamp(yaw - next.yaw_rad, -most, most);
    states_.push_back(next);
  }

  void turn_to(double yaw) {
    const double turn = std::abs(yaw - states_.back().yaw_rad);
    if (turn > 1e-6) accelerate_to(Vec3::Zero(), turn / yaw_rate_ + 1e-6, yaw);
  }

  /// Without the states that their neighbours imply.
  std::vector<State> finish() const {
    std::vector<State> kept{states_.front()};
    for (std::size_t i = 1; i + 1 < states_.size(); ++i) {
      if (!implied(kept.back(), i)) kept.push_back(states_[i]);
    }
    if (states_.size() > 1) kept.push_back(states_.back());
    for (State& s : kept) s.yaw_rad = wrap_angle(s.yaw_rad);
    return kept;
  }

 private:
  bool implied(const State& before, std::size_t i) const {
    const State &s = states_[i], &after = states_[i + 1];
    if (std::abs(after.yaw_rad - before.yaw_rad) > 3) return false;  // the shortest way would flip
    const double u = (s.t - before.t).s() / (after.t - before.t).s();
    const Vec3 v = before.v_mps + u * (after.v_mps - before.v_mps);
    const double yaw = before.yaw_rad + u * (after.yaw_rad - before.yaw_rad);
    const Vec3 p = before.p + (before.v_mps + v) * ((s.t - before.t).s() / 2);
    return (v - s.v_mps).norm() < 1e-6 && (p - s.p).norm() < 1e-5 &&
           std::abs(yaw - s.yaw_rad) < 1e-3;
  }

  double yaw_rate_;
  std::vector<State> states_;
};

/// A straight: accelerate, cruise, brake.
void write_straight(Writer& writer, const Course::Piece& piece, double from, double to, Rates rates,
                    double yaw_from, double yaw_to) {
  const double length = piece.length_m, cap = std::min(piece.soft_mps, piece.hard_mps);
  const double peak = std::sqrt(
      (2 * rates.accel * rates.brake * length + rates.brake * from * from + rates.accel * to * to) /
      (rates.accel + rates.brake));
  const double top = std::max({from, to, std::min(cap, peak)});
  const double up = (top * top - from * from) / (2 * rates.accel);
  const double down = (top * top - to * to) / (2 * rates.brake);
  const double cruise = std::max(0.0, length - up - down);
  const auto yaw = [&](double s) {
    return yaw_from + (yaw_to - yaw_from) * std::min(1.0, s / length);
  };
  writer.accelerate_to(top * piece.from_dir, (top - from) / rates.accel, yaw(up));
  if (top > kStill_mps) {
    writer.accelerate_to(top * piece.from_dir, cruise / top, yaw(up + cruise));
  }
  writer.accelerate_to(to * piece.from_dir, (top - to) / rates.brake, yaw_to);
}

std::optional<std::vector<State>> drive(const Course& course, const State& now,
                                        const Limits& limits) {
  const double v0 = now.v_mps.norm();
  // Braking is planned a little below the limit, and done at it when a new plan finds the vehicle a
  // little too fast: replanning on the way to a corner does not end in a stop. The last step covers
  // rounding.
  for (const double brake : {0.95, 1.0, 1.015}) {
    const Rates rates{limits.accel_mps2, limits.accel_mps2 * brake};
    const auto speeds = node_speeds(course, v0 > kAtRest_mps ? v0 : 0, rates);
    if (speeds.empty()) continue;
    Writer writer(now, limits.yaw_rate_radps);
    for (std::size_t k = 0; k < course.pieces.size(); ++k) {
      const auto& piece = course.pieces[k];
      const double yaw_from = course.nodes[k].yaw_out_rad, yaw_to = course.nodes[k + 1].yaw_in_rad;
      if (course.nodes[k].yaw_in_rad != yaw_from && speeds[k] <= kStill_mps)
        writer.turn_to(yaw_from);
      if (piece.bend) {
        writer.accelerate_to(speeds[k] * piece.to_dir, piece.length_m / speeds[k], yaw_to);
      } else {
        write_straight(writer, piece, speeds[k], speeds[k + 1], rates, yaw_from, yaw_to);
      }
    }
    writer.turn_to(course.nodes.back().yaw_out_rad);
    return writer.finish();
  }
  return std::nullopt;
}

std::vector<Vec3> from_here(const Path& path, const Vec3& here) {
  std::vector<Vec3> points{here};
  for (const Vec3& p : path.points) {
    if ((p - points.back()).norm() > kApart_m) points.push_back(p);
  }
  return points;
}

/// Points that begin along the velocity: the vehicle swings into the first leg by a bend that
/// starts where it is.
struct FlowingStart {
  std::vector<Vec3> points;
  bool bends = false;
};
std::optional<FlowingStart> flowing_start(const std::vector<Vec3>& points, const State& now,
                                          const Limits& limits) {
  const double v0 = now.v_mps.norm();
  const Vec3 along = now.v_mps / v0, leg = points[1] - points[0];
  const double angle = std::acos(std::clamp(along.dot(leg.normalized()), -1.0, 1.0));
  if (angle > kSwing) return std::nullopt;
  if ((leg.normalized() - along).norm() < 1e-7) return FlowingStart{points, false};
  double d = 2e-4;
  for (int i = 0; i < 4; ++i) {
    const Vec3 rest = points[1] - (points[0] + d * along);
    const double sine = (rest.normalized() - along).norm() / 2;
    d = std::max(d, 1.02 * v0 * v0 * sine / limits.accel_mps2);
    if (d > 0.45 * rest.norm()) return std::nullopt;
  }
  if (angle > kAligned && d * std::sin(angle) > kSwing_m) return std::nullopt;
  FlowingStart start{points, true};
  start.points.insert(start.points.begin() + 1, points[0] + d * along);
  return start;
}

/// From `here`, off the path, to its nearest point within a few metres of its start, and on.
Path rejoin(const Path& path, const Vec3& here) {
  constexpr double kLook_m = 3;
  double best = std::numeric_limits<double>::infinity(), s = 0;
  std::size_t leg = 0;
  Vec3 join = path.points.front();
  for (std::size_t i = 1; i < path.points.size() && s < kLook_m; ++i) {
    const Vec3 a = path.points[i - 1], d = path.points[i] - a;
    const double u =
        d.squaredNorm() > 0 ? std::clamp((here - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
    const Vec3 p = a + u * d;
    if ((here - p).norm() < best) {
      best = (here - p).norm();
      leg = i;
      join = p;
    }
    s += d.norm();
  }
  Path rest;
  rest.points = {here, join};
  for (std::size_t i = std::max<std::size_t>(leg, 1); i < path.points.size(); ++i)
    rest.points.push_back(path.points[i]);
  return rest;
}

std::optional<std::vector<State>> try_flowing(const Path& path, const TimingRequest& request,
                                              const Limits& limits, double corner_m, double see_m) {
  const State& now = request.now;
  auto points = from_here(path, now.p);
  CourseRequest course;
  course.speed_mps = now.v_mps.norm();
  if (course.speed_mps > kAtRest_mps) {
    if (points.size() < 2) return std::nullopt;
    auto start = flowing_start(points, now, limits);
    if (!start) return std::nullopt;
    const double heading = std::atan2(now.v_mps.y(), now.v_mps.x());
    const bool level = now.v_mps.head<2>().norm() > 0.5;
    if (request.look_ahead && level && std::abs(wrap_angle(heading - now.yaw_rad)) > kLookingAway)
      return std::nullopt;
    points = std::move(start->points);
    course.first_leg_bends = start->bends;
  } else {
    course.speed_mps = 0;
  }
  if (points.size() < 2) {
    Writer writer(now, limits.yaw_rate_radps);
    if (request.final_yaw_rad)
      writer.turn_to(now.yaw_rad + wrap_angle(*request.final_yaw_rad - now.yaw_rad));
    return writer.finish();
  }
  course.points = std::move(points);
  course.yaw_rad = now.yaw_rad;
  course.final_yaw_rad = request.final_yaw_rad;
  course.corner_m = corner_m;
  course.look_ahead = request.look_ahead;
  course.max_speed_mps = std::min(limits.speed_mps, sight_speed(see_m, limits.accel_mps2)) *
                         std::clamp(request.speed_scale, 0.05, 1.0);
  return drive(lay_course(course, limits), now, limits);
}

}  // namespace

Trajectory time_path(const Path& path, const TimingRequest& request, const Limits& limits,
                     double corner_m, double see_m) {
  MUSTER_CHECK(limits.speed_mps > 0 && limits.accel_mps2 > 0 && limits.yaw_rate_radps > 0);
  if (auto states = try_flowing(path, request, limits, corner_m, see_m))
    return Trajectory(std::move(*states));

  // The velocity does not fit the path: stop, then start anew from there.
  auto states = stop(request.now, limits).states();
  TimingRequest rest = request;
  rest.now = states.back();
  rest.now.v_mps = Vec3::Zero();
  const Path way = path.points.empty() ? path : rejoin(path, rest.now.p);
  const auto then = try_flowing(way, rest, limits, corner_m, see_m);
  MUSTER_CHECK(then.has_value());
  states.insert(states.end(), then->begin() + 1, then->end());
  return Trajectory(std::move(states));
}

}  // namespace muster::nav
