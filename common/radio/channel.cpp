#include "common/radio/channel.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace muster::radio {
namespace {

std::pair<RobotId, RobotId> in_order(RobotId a, RobotId b) { return std::minmax({a, b}); }

bool comes_first(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

Channel::Channel(const ChannelConfig& config, LineOfSight line_of_sight)
    : config_(config), line_of_sight_(std::move(line_of_sight)) {
  if (!(config.range_m > 0) || !std::isfinite(config.range_m)) {
    throw std::invalid_argument("range_m: a radio's range is a positive number of metres");
  }
  if (config.line_of_sight && !line_of_sight_) {
    throw std::invalid_argument("line_of_sight: a radio that walls stop has to be told of walls");
  }
  for (const auto& [a, b] : config.always_on) always_on_.push_back(in_order(a, b));
  std::ranges::sort(always_on_);
}

bool Channel::always_on(RobotId a, RobotId b) const {
  return std::ranges::binary_search(always_on_, in_order(a, b));
}

Link Channel::between(RobotId a, const Vec3& place_a, RobotId b, const Vec3& place_b) const {
  if (always_on(a, b)) return Link::kUp;
  return a < b ? directed(place_a, place_b) : directed(place_b, place_a);
}

Link Channel::between(const Vec3& a, const Vec3& b) const {
  return comes_first(a, b) ? directed(a, b) : directed(b, a);
}

Link Channel::directed(const Vec3& from, const Vec3& to) const {
  // Written so that a place that is no number is out of range.
  if (!((to - from).squaredNorm() <= config_.range_m * config_.range_m)) return Link::kRange;
  if (config_.line_of_sight && !line_of_sight_(from, to)) return Link::kWall;
  return Link::kUp;
}

}  // namespace muster::radio
