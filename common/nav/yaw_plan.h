#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "common/geometry/pose.h"

namespace muster::nav {

/// The heading of a direction of motion; nullopt when it is nearly vertical.
std::optional<double> heading_of(const Vec3& dir);

struct YawRequest {
  struct Leg {
    Vec3 dir = Vec3::UnitX();
    double start_m = 0, length_m = 0;
    double bend_before_m = 0;  ///< half-length of the bend at its start
  };
  std::vector<Leg> legs;
  double now_rad = 0;
  std::optional<double> final_rad;
  double moving_mps = 0;  ///< > 0: cannot turn in place before it starts
  double rate_radps = 1.5;
  bool ground = false;
  bool look_ahead = true;  ///< false: a short move, the camera need not point along it
};

/// Yaw as a function of the distance along a polyline, unwrapped and continuous.
///
/// A UAV looks where it flies: the mean of the motion's heading over a window of 2 m around it, so
/// that the camera begins to turn 1 m before a corner and ends 1 m after it, and the turns of
/// corners close to each other add up by themselves. From the start it converges within the first
/// metre, towards the final yaw it leaves the heading within the last. A UGV looks along its
/// wheels: the heading itself, linear within bends, turned in place at the start and at stops.
class YawPlan {
 public:
  explicit YawPlan(const YawRequest& request);

  double at(double s_m) const;
  /// UGV: the heading after pivoting before leg `leg`.
  double after_pivot(std::size_t leg) const { return headings_[leg]; }
  /// Stretches within which the yaw changes, ordered, disjoint.
  const std::vector<std::pair<double, double>>& turning() const { return turning_; }

 private:
  void find_headings();
  void find_turning();
  double base(double s_m) const;
  double integral(double s_m) const;

  YawRequest request_;
  double total_m_ = 0;
  std::vector<double> headings_;  ///< per leg, unwrapped
  std::vector<double> integral_;  ///< of the heading, up to the start of each leg
  double start_offset_rad_ = 0, start_m_ = 0;
  double end_offset_rad_ = 0, end_m_ = 0;
  std::vector<std::pair<double, double>> turning_;
};

}  // namespace muster::nav
