#include "common/nav/course.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/nav/yaw_plan.h"

namespace muster::nav {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSteep =
    30 * kDegree;  ///< half the camera's vertical view: what is ahead is not seen
constexpr double kSteepSpeed_mps = 1;
constexpr double kBlind = 50 * kDegree;  ///< half the camera's horizontal view, and a little
constexpr double kBlindSpeed_mps = 0.5;
constexpr double kLongestShortMove_m = 1;      ///< a shorter move stays within what was seen before
constexpr double kGroundPivot = 30 * kDegree;  ///< a UGV turns in place at sharper corners
constexpr double kYawRateMargin = 0.98;
constexpr double kYawStep_m = 0.25;  ///< nodes at least this close where the yaw turns
constexpr double kShortestPiece_m = 0.02;

struct Leg {
  Vec3 dir = Vec3::UnitX();
  double length_m = 0, start_m = 0;
};

std::vector<Leg> legs_of(const std::vector<Vec3>& points) {
  std::vector<Leg> legs;
  double s = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Vec3 d = points[i] - points[i - 1];
    legs.push_back({d.normalized(), d.norm(), s});
    s += d.norm();
  }
  return legs;
}

double sin_half_turn(const Vec3& a, const Vec3& b) { return std::min(1.0, (b - a).norm() / 2); }

/// Half-lengths d of the bends; element i is the corner before leg i. 0: none (straight on, or a
/// stop).
std::vector<double> bends_of(const CourseRequest& request, const Limits& limits,
                             const std::vector<Leg>& legs) {
  std::vector<double> d(legs.size() + 1, 0);
  for (std::size_t i = 1; i < legs.size(); ++i) {
    const double sine = sin_half_turn(legs[i - 1].dir, legs[i].dir);
    if (sine < 1e-9) continue;
    if (limits.ground && 2 * std::asin(sine) > kGroundPivot) continue;
    if (i == 1 && request.first_leg_bends) {
      d[i] = legs[0].length_m;
      continue;
    }
    const double v = request.max_speed_mps;
    const double useful = std::max(0.05, v * v * sine / limits.accel_mps2);
    // A leg is shared by its two bends; the first is all the first bend's when the vehicle is
    // moving already.
    double room_before = legs[i - 1].length_m / 2;
    if (i == 1 && request.speed_mps > 0) room_before = legs[0].length_m * 0.9;
    if (i == 2 && request.first_leg_bends) {
      room_before = std::min(legs[1].length_m / 2, legs[1].length_m - d[1]);
    }
    d[i] = std::min({2 * request.corner_m / sine, useful, room_before, legs[i].length_m / 2});
  }
  return d;
}

/// Where along the polyline nodes lie on the straight part of a leg: its ends, and where the yaw
/// turns.
std::vector<double> nodes_on(double from_m, double to_m, const YawPlan& yaw) {
  std::vector<double> nodes{from_m};
  for (const auto& [low, high] : yaw.turning()) {
    const double a = std::max(low, from_m), b = std::min(high, to_m);
    if (b - a < kShortestPiece_m) continue;
    const int steps = static_cast<int>(std::ceil((b - a) / kYawStep_m));
    for (int i = 0; i <= steps; ++i) {
      const double s = a + (b - a) * i / steps;
      if (s - nodes.back() > kShortestPiece_m && to_m - s > kShortestPiece_m) nodes.push_back(s);
    }
  }
  nodes.push_back(to_m);
  return nodes;
}

class Layer {
 public:
  Layer(const CourseRequest& request, const Limits& limits)
      : request_(request),
        limits_(limits),
        legs_(legs_of(request.points)),
        bends_(bends_of(request, limits, legs_)),
        yaw_(yaw_request()) {
    total_m_ = legs_.back().start_m + legs_.back().length_m;
  }

  Course lay() {
    course_.nodes.push_back({request_.yaw_rad, yaw_.at(0)});
    for (std::size_t i = 0; i < legs_.size(); ++i) {
      const Leg& leg = legs_[i];
      const double from = leg.start_m + bends_[i];
      const double to = leg.start_m + leg.length_m - bends_[i + 1];
      if (to - from > 1e-9) {
        const auto nodes = nodes_on(from, to, yaw_);
        for (std::size_t k = 1; k < nodes.size(); ++k) straight(leg, nodes[k - 1], nodes[k]);
      }
      if (i + 1 == legs_.size()) break;
      if (bends_[i + 1] > 0) {
        bend(leg, legs_[i + 1], bends_[i + 1]);
      } else if (limits_.ground) {
        course_.nodes.back().yaw_out_rad = yaw_.after_pivot(i + 1);
      }
    }
    Course::Node& last = course_.nodes.back();
    last.yaw_out_rad = last.yaw_in_rad;
    if (request_.final_yaw_rad) {
      last.yaw_out_rad += wrap_angle(*request_.final_yaw_rad - last.yaw_in_rad);
    }
    return std::move(course_);
  }

 private:
  YawRequest yaw_request() const {
    YawRequest r;
    r.now_rad = request_.yaw_rad;
    r.final_rad = request_.final_yaw_rad;
    r.moving_mps = request_.speed_mps;
    r.rate_radps = limits_.yaw_rate_radps;
    r.ground = limits_.ground;
    double total = 0;
    for (const Leg& leg : legs_) total += leg.length_m;
    r.look_ahead = limits_.ground || (request_.look_ahead && total >= kLongestShortMove_m);
    for (std::size_t i = 0; i < legs_.size(); ++i) {
      r.legs.push_back({legs_[i].dir, legs_[i].start_m, legs_[i].length_m, bends_[i]});
    }
    return r;
  }

  double steepness_cap(const Vec3& dir) const {
    if (!request_.look_ahead) return limits_.speed_mps;
    return std::abs(dir.z()) > std::sin(kSteep) ? kSteepSpeed_mps : limits_.speed_mps;
  }

  double look_cap(const Course::Piece& piece, double yaw_from, double yaw_to) const {
    if (limits_.ground || !request_.look_ahead || total_m_ < kLongestShortMove_m)
      return limits_.speed_mps;
    constexpr int kSamples = 4;  // within a bend the motion turns, too
    for (int i = 0; i <= kSamples; ++i) {
      const double u = double(i) / kSamples;
      const Vec3 along = (1 - u) * piece.from_dir + u * piece.to_dir;
      if (along.norm() < 0.2) continue;  // nearly standing in a hairpin
      const auto heading = heading_of(along.normalized());
      const double yaw = yaw_from + u * (yaw_to - yaw_from);
      if (heading && std::abs(wrap_angle(yaw - *heading)) > kBlind) return kBlindSpeed_mps;
    }
    return limits_.speed_mps;
  }

  void add(Course::Piece piece, double yaw_end) {
    Course::Node& from = course_.nodes.back();
    const double turn = std::abs(yaw_end - from.yaw_out_rad);
    piece.soft_mps =
        std::min({request_.max_speed_mps, steepness_cap(piece.from_dir),
                  steepness_cap(piece.to_dir), look_cap(piece, from.yaw_out_rad, yaw_end)});
    if (turn > 1e-9) {
      const double rate = limits_.yaw_rate_radps * kYawRateMargin;
      piece.soft_mps = std::min(piece.soft_mps, rate * piece.length_m / turn);
    }
    course_.pieces.push_back(piece);
    course_.nodes.push_back({yaw_end, yaw_end});
  }

  void straight(const Leg& leg, double from_m, double to_m) {
    Course::Piece piece;
    piece.from_dir = piece.to_dir = leg.dir;
    piece.length_m = to_m - from_m;
    piece.hard_mps = limits_.speed_mps;
    add(piece, yaw_.at(to_m));
  }

  void bend(const Leg& before, const Leg& after, double d) {
    Course::Piece piece;
    piece.bend = true;
    piece.from_dir = before.dir;
    piece.to_dir = after.dir;
    piece.length_m = 2 * d;
    const double sine = sin_half_turn(before.dir, after.dir);
    piece.hard_mps = std::min(limits_.speed_mps, std::sqrt(limits_.accel_mps2 * d / sine));
    add(piece, yaw_.at(after.start_m + d));
  }

  const CourseRequest& request_;
  const Limits& limits_;
  std::vector<Leg> legs_;
  std::vector<double> bends_;
  YawPlan yaw_;
  double total_m_ = 0;
  Course course_;
};

}  // namespace

Course lay_course(const CourseRequest& request, const Limits& limits) {
  return Layer(request, limits).lay();
}

}  // namespace muster::nav
