#pragma once

#include <cstdint>
#include <vector>

#include "commsim/world/scene.h"

namespace muster::world {

/// Where the flying robots of a mission can get to from their starts: a flood fill over the 0.25 m
/// cells of the hull in whose centres the largest of them keeps its body, the mission's clearance
/// and 0.1 m more away from every surface. What RULES.md means by "reachable"; used to judge
/// features and coverage, never by a robot.
class ReachableSpace {
 public:
  static constexpr double kCell_m = 0.25;
  static constexpr double kExtra_m = 0.1;

  ReachableSpace(const Scene& scene, const mission::Mission& mission);

  /// Is the cell that `p` lies in reachable?
  bool contains(const Vec3& p) const {
    const Eigen::Vector3i i = ((p - low_) / kCell_m).array().floor().cast<int>();
    if ((i.array() < 0).any() || (i.array() >= cells_.array()).any()) return false;
    return state_[index(i)] == State::kReached;
  }
  double volume_m3() const;
  /// Kept from every surface, in the centre of a reachable cell.
  double margin_m() const { return margin_m_; }

 private:
  enum class State : std::uint8_t { kFree, kBlocked, kReached };
  std::size_t index(const Eigen::Vector3i& i) const {
    return (static_cast<std::size_t>(i.z()) * static_cast<std::size_t>(cells_.y()) +
            static_cast<std::size_t>(i.y())) *
               static_cast<std::size_t>(cells_.x()) +
           static_cast<std::size_t>(i.x());
  }
  Vec3 center(const Eigen::Vector3i& i) const {
    return low_ + kCell_m * (i.cast<double>() + Vec3::Constant(0.5));
  }
  void block_outside(const Box& hull, double margin_m);
  void block_around(const Vec3& a, const Vec3& b, const Vec3& c);
  void flood(const Vec3& start);

  Vec3 low_ = Vec3::Zero();
  Eigen::Vector3i cells_ = Eigen::Vector3i::Zero();
  double margin_m_ = 0;
  std::vector<State> state_;
};

}  // namespace muster::world
