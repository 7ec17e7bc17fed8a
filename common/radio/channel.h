#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "common/core/ids.h"
#include "common/geometry/pose.h"

namespace muster::radio {

struct ChannelConfig {
  double range_m = 5;
  bool line_of_sight = true;  ///< walls stop the radio
  std::vector<std::pair<RobotId, RobotId>>
      always_on;  ///< pairs that always hear each other (station to station)
};

/// Does one hear the other, and if not, why?
enum class Link : std::uint8_t { kUp, kRange, kWall };

/// Nothing solid between a and b. The relay asks the true scene; a planner asks what it knows of
/// its map.
using LineOfSight = std::function<bool(const Vec3& a, const Vec3& b)>;

/// The radio of the papers: who is within range and in line of sight hears everything, at once and
/// without loss; nobody else hears anything. The simulator decides with it and planners predict
/// with it, each with its own idea of what is solid.
///
///     always on ── yes ──▶ up
///        │ no
///     within range ── no ──▶ range
///        │ yes
///     line of sight ── no ──▶ wall       (asked last: it is what costs)
///        │ yes
///        up
///
/// Symmetric, also in floating point: rays go from the smaller id (or the lexicographically smaller
/// place) to the larger.
class Channel {
 public:
  /// Throws std::invalid_argument unless range_m is positive and finite, and when line of sight is
  /// asked for without a way to tell.
  Channel(const ChannelConfig& config, LineOfSight line_of_sight);

  const ChannelConfig& config() const { return config_; }
  bool always_on(RobotId a, RobotId b) const;
  /// Between two robots that are at these places.
  Link between(RobotId a, const Vec3& place_a, RobotId b, const Vec3& place_b) const;
  /// Between two places, whoever may be there.
  Link between(const Vec3& a, const Vec3& b) const;

 private:
  Link directed(const Vec3& from, const Vec3& to) const;

  ChannelConfig config_;
  std::vector<std::pair<RobotId, RobotId>> always_on_;  // smaller id first, ascending
  LineOfSight line_of_sight_;
};

}  // namespace muster::radio
