#include "common/radio/channel.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "common/core/hash.h"
#include "common/core/random.h"
#include "common/radio/path_loss.h"

namespace muster::radio {
namespace {

constexpr double kUnlikely = 3;  // so many σ of the asymmetric part no link is hoped for

std::pair<RobotId, RobotId> in_order(RobotId a, RobotId b) { return std::minmax({a, b}); }

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument(what);
}

void check(const ChannelConfig& c, const Obstacles& obstacles) {
  require(c.range_m > 0 && std::isfinite(c.range_m),
          "range_m: a radio's range is a positive number of metres");
  require(c.loss >= 0 && c.loss <= 1, "loss: a probability is expected");
  require(c.frame_bytes > 0, "frame_bytes: a frame holds at least one byte");
  const bool walls_matter = c.path_loss ? c.path_loss->wall_loss_db > 0 : c.line_of_sight;
  require(!walls_matter || obstacles.line_of_sight || obstacles.walls,
          "line_of_sight: a radio that walls stop has to be told of walls");
  require(!c.path_loss || c.path_loss->fade_db > 0, "fade_db: must be greater than 0");
}

}  // namespace

Channel::Channel(const ChannelConfig& config, Obstacles obstacles, std::uint64_t seed)
    : config_(config), obstacles_(std::move(obstacles)), seed_(seed) {
  check(config_, obstacles_);
  for (const auto& [a, b] : config.always_on) always_on_.push_back(in_order(a, b));
  std::ranges::sort(always_on_);
  if (config.path_loss && config.path_loss->shadowing_db > 0) {
    shadowing_.emplace(seed, config.path_loss->shadowing_distance_m);
  }
}

Channel::Channel(const ChannelConfig& config, LineOfSight line_of_sight, std::uint64_t seed)
    : Channel(config, Obstacles{std::move(line_of_sight)}, seed) {}

bool Channel::always_on(RobotId a, RobotId b) const {
  return std::ranges::binary_search(always_on_, in_order(a, b));
}

Channel::Path Channel::path(RobotId a, const Vec3& place_a, RobotId b, const Vec3& place_b) const {
  if (always_on(a, b)) return {.link = Link::kUp, .certain = true};
  const Vec3 &from = a < b ? place_a : place_b, &to = a < b ? place_b : place_a;
  return config_.path_loss ? faded(from, to) : disc(from, to);
}

Channel::Path Channel::disc(const Vec3& from, const Vec3& to) const {
  // Written so that a place that is no number is out of range.
  if (!((to - from).squaredNorm() <= config_.range_m * config_.range_m)) {
    return {.link = Link::kRange, .certain = true};
  }
  const bool wall = config_.line_of_sight && !obstacles_.line_of_sight(from, to);
  return {.link = wall ? Link::kWall : Link::kUp, .certain = true};
}

Channel::Path Channel::faded(const Vec3& from, const Vec3& to) const {
  const PathLossConfig& c = *config_.path_loss;
  const double distance_m = (to - from).norm();
  if (!std::isfinite(distance_m)) return {.link = Link::kRange, .certain = true};
  const double luck_db = kUnlikely * c.asymmetry_db;
  const auto hopeless = [&](double signal_dbm) {
    return frame_loss(c, signal_dbm + luck_db) >= kHopeless;
  };
  const double mean_dbm = open_signal_dbm(c, distance_m);
  // Before the waves of the shadowing are summed up, and before any ray.
  if (hopeless(mean_dbm + 4 * c.shadowing_db)) return {.link = Link::kRange, .certain = true};
  const double open_dbm =
      mean_dbm + (shadowing_ ? c.shadowing_db * shadowing_->between(from, to) : 0);
  if (hopeless(open_dbm)) return {.link = Link::kRange, .certain = true};
  int walls = 0;
  if (c.wall_loss_db > 0) {
    walls = obstacles_.walls ? obstacles_.walls(from, to)
                             : static_cast<int>(!obstacles_.line_of_sight(from, to));
  }
  const double signal_dbm = open_dbm - walls * c.wall_loss_db;
  return {.link = hopeless(signal_dbm) ? Link::kWall : Link::kUp,
          .open_dbm = open_dbm,
          .signal_dbm = signal_dbm};
}

Reception Channel::hear(const Path& path, RobotId from, RobotId to) const {
  if (path.link != Link::kUp || path.certain) return {path.link};
  const PathLossConfig& c = *config_.path_loss;
  const double own_db = asymmetry_db(from, to);
  const double lost = frame_loss(c, path.signal_dbm + own_db);
  if (lost < kHopeless) return {Link::kUp, lost};
  return {frame_loss(c, path.open_dbm + own_db) < kHopeless ? Link::kWall : Link::kRange};
}

Reception Channel::hear(RobotId from, const Vec3& place_from, RobotId to,
                        const Vec3& place_to) const {
  return hear(path(from, place_from, to, place_to), from, to);
}

double Channel::asymmetry_db(RobotId from, RobotId to) const {
  const double sigma_db = config_.path_loss->asymmetry_db;
  if (sigma_db <= 0) return 0;
  const std::uint64_t direction = Hasher(seed_).add(to.value).value();
  const double z = Random(direction, from, "radio asymmetry").normal();
  return sigma_db * std::clamp(z, -kUnlikely, kUnlikely);
}

bool Channel::is_lost(const Reception& reception, RobotId from, std::uint64_t n, RobotId to,
                      std::size_t bytes, double least_loss) const {
  const double p = std::max(least_loss, message_loss(config_, reception.frame_loss, bytes));
  if (p <= 0) return false;
  const std::uint64_t message = Hasher(seed_).add(n).add(to.value).value();
  return Random(message, from, "radio loss").chance(p);
}

}  // namespace muster::radio
