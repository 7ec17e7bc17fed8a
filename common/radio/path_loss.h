#pragma once

#include <cstddef>

#include "common/radio/config.h"

/// The arithmetic of a fading signal: pure functions of a configuration. What a place does to it by
/// chance is Shadowing's; who hears whom is Channel's.
namespace muster::radio {

/// On a free line of `distance_m`, before shadowing. Nearer than 10 cm counts as 10 cm.
double open_signal_dbm(const PathLossConfig& c, double distance_m);

/// The probability that a frame is lost at this signal: 0.1 at the sensitivity, towards 1 below it
/// and 0 above.
double frame_loss(const PathLossConfig& c, double signal_dbm);

/// From here on a link counts as down, whatever the draw would say: a frame in a hundred is none.
inline constexpr double kHopeless = 0.99;

/// That a message of so many bytes is lost when each of its frames is with `frame_loss`.
double message_loss(const ChannelConfig& c, double frame_loss, std::size_t bytes);

/// The probability that a frame gets through over that distance and so many walls, for somebody who
/// knows the model but not the place's shadowing: what a planner may predict. Without path loss: 1
/// within range (and without walls, if they matter), else 0. Never grows with distance or walls.
double forecast(const ChannelConfig& c, double distance_m, int walls);

/// The distance at which the forecast in the open has fallen to 0.9; without path loss the range.
double dependable_range_m(const ChannelConfig& c);

}  // namespace muster::radio
