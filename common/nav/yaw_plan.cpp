#include "common/nav/yaw_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace muster::nav {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kVertical = 75 * kDegree;
constexpr double kHalfWindow_m =
    1;  ///< 90° within 2 m at 1.5 rad/s: 1.9 m/s, hardly slower than without turning
constexpr double kMovingOff =
    45 * kDegree;  ///< the camera may be this far off the motion: half its view

}  // namespace

std::optional<double> heading_of(const Vec3& dir) {
  if (std::abs(dir.z()) > std::sin(kVertical)) return std::nullopt;
  return std::atan2(dir.y(), dir.x());
}

YawPlan::YawPlan(const YawRequest& request) : request_(request) {
  total_m_ = request_.legs.back().start_m + request_.legs.back().length_m;
  find_headings();
  double sum = 0;
  for (std::size_t i = 0; i < headings_.size(); ++i) {
    integral_.push_back(sum);
    sum += headings_[i] * request_.legs[i].length_m;
  }

  const double off = request_.now_rad - headings_.front();
  const double kept = request_.moving_mps > 0 || !request_.look_ahead ? off
                      : request_.ground                               ? 0
                                        : std::clamp(off, -kMovingOff, kMovingOff);
  start_offset_rad_ = headings_.front() + kept - base(0);
  start_m_ = std::min(
      total_m_, std::max(std::min(kHalfWindow_m, total_m_ / 2),
                         request_.moving_mps * std::abs(start_offset_rad_) / request_.rate_radps));
  if (request_.final_rad && !request_.ground) {
    const double limit = request_.look_ahead ? kMovingOff : std::numbers::pi;
    const double heading = headings_.back();
    const double target =
        heading + std::clamp(wrap_angle(*request_.final_rad - heading), -limit, limit);
    end_offset_rad_ = target - base(total_m_);
  }
  end_m_ = request_.look_ahead ? std::min(kHalfWindow_m, total_m_ / 2) : total_m_;
  find_turning();
}

void YawPlan::find_headings() {
  std::vector<std::optional<double>> raw;
  for (const auto& leg : request_.legs) {
    raw.push_back(request_.look_ahead ? heading_of(leg.dir) : std::optional(request_.now_rad));
  }
  // A vertical leg is flown looking where the next level one will go; the last ones as before, or
  // already as wanted at the end.
  for (std::size_t i = raw.size(); i-- > 1;) {
    if (!raw[i - 1]) raw[i - 1] = raw[i];
  }
  double last = request_.now_rad;
  for (const auto& heading : raw) {
    const double aim = heading                                             ? *heading
                       : request_.final_rad && raw.front() == std::nullopt ? *request_.final_rad
                                                                           : last;
    last += wrap_angle(aim - last);
    headings_.push_back(last);
  }
}

double YawPlan::integral(double s_m) const {
  if (s_m <= 0) return headings_.front() * s_m;
  const auto& legs = request_.legs;
  const auto after = std::upper_bound(legs.begin(), legs.end(), s_m,
                                      [](double s, const auto& leg) { return s < leg.start_m; });
  const auto i = static_cast<std::size_t>(after - legs.begin()) - 1;
  return integral_[i] + headings_[i] * (s_m - legs[i].start_m);
}

double YawPlan::base(double s_m) const {
  if (!request_.ground) {
    return (integral(s_m + kHalfWindow_m) - integral(s_m - kHalfWindow_m)) / (2 * kHalfWindow_m);
  }
  const auto& legs = request_.legs;
  for (std::size_t i = legs.size(); i-- > 1;) {
    const double d = legs[i].bend_before_m;
    if (s_m >= legs[i].start_m + d && (d > 0 || s_m > legs[i].start_m)) return headings_[i];
    if (s_m > legs[i].start_m - d) {
      const double u = (s_m - legs[i].start_m + d) / (2 * d);
      return headings_[i - 1] + u * (headings_[i] - headings_[i - 1]);
    }
  }
  return headings_.front();
}

double YawPlan::at(double s_m) const {
  const double starting = start_m_ > 0 ? std::max(0.0, 1 - s_m / start_m_) : 0;
  const double ending = end_m_ > 0 ? std::max(0.0, 1 - (total_m_ - s_m) / end_m_) : 1;
  return base(s_m) + starting * start_offset_rad_ + ending * end_offset_rad_;
}

void YawPlan::find_turning() {
  constexpr double kStill = 1e-6;
  std::vector<std::pair<double, double>> stretches;
  if (std::abs(start_offset_rad_) > kStill) stretches.emplace_back(0, start_m_);
  for (std::size_t i = 1; i < headings_.size() && !request_.ground; ++i) {
    if (std::abs(headings_[i] - headings_[i - 1]) < kStill) continue;
    const double corner = request_.legs[i].start_m;
    stretches.emplace_back(corner - kHalfWindow_m, corner + kHalfWindow_m);
  }
  if (std::abs(end_offset_rad_) > kStill) stretches.emplace_back(total_m_ - end_m_, total_m_);
  std::sort(stretches.begin(), stretches.end());
  for (const auto& stretch : stretches) {
    if (!turning_.empty() && stretch.first <= turning_.back().second) {
      turning_.back().second = std::max(turning_.back().second, stretch.second);
    } else {
      turning_.push_back(stretch);
    }
  }
}

}  // namespace muster::nav
