#pragma once

#include <array>
#include <functional>
#include <vector>

#include "common/map/targets.h"
#include "common/robot/knowledge.h"

namespace muster::agent {

/// What a second of an explorer's time buys, and what it costs.
struct ViewPrice {
  double owed_weight = 1.5;  ///< m³ of unknown space that one look at 1 m² of surface is worth
  double look_period_s = 2;
  SimTime next_look;  ///< the feature detector looks at its own times
};

/// A pose, what it would show and when.
struct View {
  Pose pose;
  map::Worth worth;
  double arrive_s = 0;  ///< from now until the camera rests there
  bool look = false;    ///< stays for the next look of the detector
  double value = 0;     ///< m³ (and looks, weighed as such)
  double rate = 0;      ///< value per second until it is had
};

/// The straight way between two places is free for the body.
bool straight(const map::VoxelMap& map, const Vec3& a, const Vec3& b);

/// Seconds to fly `way_m` along `direction` and to end at `yaw_rad`, turning on the way, from rest
/// at `yaw_now_rad` or from `v_mps`.
double flight_s(double way_m, const Vec3& direction, double yaw_now_rad, double yaw_rad,
                const nav::Limits& limits, const Vec3& v_mps = Vec3::Zero());

/// The best use of a pose reached after `arrive_s`: a glance (one scan), or staying for the next
/// look.
View price(const Pose& pose, const map::Worth& worth, double arrive_s, SimTime now,
           const ViewPrice& price);

/// A lattice of places in and around one box, with what the camera would show from each: a memory
/// that is refreshed where the best may be, a counted number of places a time.
class Vantages {
 public:
  Vantages(const Box& box, const map::VoxelMap& map);

  /// The best views (best first, at most `count`, apart from each other) that a short flight
  /// reaches. `spent`: poses that did not show what they promised.
  std::vector<View> best(robot::Knowledge& knowledge, const map::Targets& targets,
                         const ViewPrice& price, std::size_t count,
                         const std::function<bool(const Pose&)>& spent);

 private:
  struct Place {
    std::array<float, map::Panorama::kHeadings> unknown_m3{}, owed_m2{};
    float most = 0;  ///< value of the best heading, when it was looked at
    SimTime seen_at;
    bool seen = false;
  };
  struct Bound {
    double rate;
    std::size_t place;
  };
  Vec3 spot(std::size_t place) const;
  std::vector<std::size_t> around(const map::VoxelMap& map, const Vec3& p) const;
  void look(std::size_t place, const map::Targets& targets, const ViewPrice& price, SimTime now);

  Vec3 first_;
  int nx_, ny_, nz_;
  std::vector<Place> places_;
};

}  // namespace muster::agent
