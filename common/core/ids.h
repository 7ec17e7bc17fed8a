#pragma once

#include <compare>
#include <cstdint>
#include <functional>

namespace muster {

/// A number that names one kind of thing and cannot be mixed up with another kind.
template <class Tag, class Rep = std::uint32_t>
struct Id {
  Rep value{};

  constexpr Id() = default;
  constexpr explicit Id(Rep v) : value(v) {}
  constexpr auto operator<=>(const Id&) const = default;
};

using RobotId = Id<struct RobotTag>;    ///< a robot or a station, as in the mission file
using RegionId = Id<struct RegionTag>;  ///< index of a bounding box in the mission file, from 0
using FeatureId =
    Id<struct FeatureTag>;  ///< a true feature; known to world, and to robots by inspection
using MeetingId =
    Id<struct MeetingTag, std::uint64_t>;  ///< counts the meetings of one pair, from 1

/// The simulator's own processes take part in the barrier under these ids.
inline constexpr RobotId kWorldId{0xFFFFFFFEu};
inline constexpr RobotId kRadioId{0xFFFFFFFDu};
/// On the wire: "everyone" or "none".
inline constexpr RobotId kNoRobot{0xFFFFFFFFu};
inline constexpr RegionId kNoRegion{0xFFFFFFFFu};

}  // namespace muster

template <class Tag, class Rep>
struct std::hash<muster::Id<Tag, Rep>> {
  std::size_t operator()(const muster::Id<Tag, Rep>& id) const noexcept {
    return std::hash<Rep>{}(id.value);
  }
};
