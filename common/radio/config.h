#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/core/ids.h"

/// What a radio is. Defaults: the papers' radio. Filled from a mission's `radio` key; presets.h has
/// the ones that exist and where their numbers come from.
namespace muster::radio {

/// How a signal fades on its way, in dB:
///
///     signal = tx_power − loss_at_1m − 10·exponent·log10(d)          with the distance,
///              + shadowing(a, b)                                     with what stands around,
///              − wall_loss per wall                                  with what stands between,
///              + asymmetry(from → to)                                with the two devices
///
/// and how a frame's loss grows when it has faded: 10 % at the sensitivity, as data sheets define
/// it, and ×1/9 … ×9 of the odds for every 2.2 `fade_db`.
struct PathLossConfig {
  double tx_power_dbm = 15;      ///< with the antennas' gains
  double sensitivity_dbm = -82;  ///< a frame is lost with p = 0.1 at this signal
  double loss_at_1m_db = 47.2;
  double exponent = 2;
  double shadowing_db = 4;           ///< σ of what both directions share
  double shadowing_distance_m = 10;  ///< moved so far, its correlation has fallen to 1/e
  double asymmetry_db = 2;           ///< σ of what a direction has of its own
  double wall_loss_db = 20;
  double fade_db = 2;  ///< how gradually the radio fails
};

struct ChannelConfig {
  /// Without path loss: nobody hears beyond. With it: what planners may count on in the open (see
  /// `dependable_range_m`); the signal alone decides who hears.
  double range_m = 5;
  bool line_of_sight = true;  ///< without path loss: walls stop the radio
  std::vector<std::pair<RobotId, RobotId>>
      always_on{};  ///< pairs that always hear each other (station to station)
  std::optional<PathLossConfig> path_loss{};
  double loss = 0;           ///< a message is lost with this probability whatever its signal
  double bit_rate_mbps = 0;  ///< shared by all who hear each other; 0: no limit
  std::uint32_t frame_bytes = 1400;  ///< longer messages travel in several frames, all needed
  double frame_overhead_us = 0;      ///< on air before and after each frame
  double queue_ms = 200;             ///< a message that waited so long for the air is dropped
  double latency_ms = 0;             ///< from the last bit sent until it is heard
};

/// A second radio at another frequency that every robot has (S0.18): all that is sent goes out on
/// both, and what the first did not carry the second may.
struct MeshConfig {
  std::string preset;
  ChannelConfig channel;
  std::uint32_t hops = 1;  ///< who hears a message sends it on, until it has gone so far
};

struct RadioConfig : ChannelConfig {
  std::string preset = "paper";
  std::optional<MeshConfig> mesh{};
};

}  // namespace muster::radio
