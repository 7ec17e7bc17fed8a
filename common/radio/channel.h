#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/core/ids.h"
#include "common/geometry/pose.h"
#include "common/radio/config.h"
#include "common/radio/shadowing.h"

namespace muster::radio {

/// Does one hear the other, and if not, what is it that stops the signal?
enum class Link : std::uint8_t { kUp, kRange, kWall };

/// What stands between two places. The relay asks the true scene; a planner asks what it knows of
/// its map.
struct Obstacles {
  /// Nothing solid between a and b.
  std::function<bool(const Vec3& a, const Vec3& b)> line_of_sight;
  /// How many walls a line from a to b crosses. Left out: one, where there is no line of sight.
  std::function<int(const Vec3& a, const Vec3& b)> walls{};
};
using LineOfSight = std::function<bool(const Vec3& a, const Vec3& b)>;

/// How a transmission arrives.
struct Reception {
  Link link{};
  double frame_loss = 0;  ///< of a link that is up, by its signal; 0 without path loss
};

/// Who hears whom: the one model with which the simulator decides and planners predict, each with
/// its own idea of what is solid (planners by `forecast`, path_loss.h: they cannot know the
/// shadowing).
///
///     always on ── yes ──▶ up
///        │ no
///     within range, or signal enough on a free line ── no ──▶ range
///        │ yes
///     line of sight, or signal enough behind the walls ── no ──▶ wall    (asked last: rays cost)
///        │ yes
///        up, and lost or not by the draw of (seed, sender, number, receiver)
///
/// Everything follows from the configuration, the seed and the question: no state, so the order of
/// questions does not matter. What both directions share is the same to the last bit: rays go from
/// the smaller id to the larger.
class Channel {
 public:
  /// Throws std::invalid_argument when a number is out of reason, or when walls matter and nobody
  /// tells of them.
  Channel(const ChannelConfig& config, Obstacles obstacles, std::uint64_t seed = 0);
  Channel(const ChannelConfig& config, LineOfSight line_of_sight, std::uint64_t seed = 0);

  const ChannelConfig& config() const { return config_; }
  bool always_on(RobotId a, RobotId b) const;

  /// What the two directions of a pair have in common: all that takes rays.
  struct Path {
    Link link{};
    bool certain = false;   ///< no signal to speak of: always on, or without path loss
    double open_dbm = 0;    ///< as it would be without the walls
    double signal_dbm = 0;  ///< as it is, but for what a direction has of its own
  };
  Path path(RobotId a, const Vec3& place_a, RobotId b, const Vec3& place_b) const;
  /// What `to` hears of `from` on their path.
  Reception hear(const Path& path, RobotId from, RobotId to) const;
  Reception hear(RobotId from, const Vec3& place_from, RobotId to, const Vec3& place_to) const;

  /// Whether message `n` of `from` is lost on its way to `to`, on a link that is up; with
  /// `least_loss` or more as its probability.
  bool is_lost(const Reception& reception, RobotId from, std::uint64_t n, RobotId to,
               std::size_t bytes, double least_loss = 0) const;

 private:
  Path disc(const Vec3& from, const Vec3& to) const;
  Path faded(const Vec3& from, const Vec3& to) const;
  /// Of one direction between two devices, the same all mission long.
  double asymmetry_db(RobotId from, RobotId to) const;

  ChannelConfig config_;
  std::vector<std::pair<RobotId, RobotId>> always_on_;  // smaller id first, ascending
  Obstacles obstacles_;
  std::uint64_t seed_;
  std::optional<Shadowing> shadowing_;
};

}  // namespace muster::radio
