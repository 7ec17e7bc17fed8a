#include "common/radio/path_loss.h"

#include <algorithm>
#include <cmath>

namespace muster::radio {
namespace {

constexpr double kNearest_m = 0.1;
constexpr double kOddsAtSensitivity = 9;  // nine frames come through for one that does not
constexpr double kDependable = 0.9;

}  // namespace

double open_signal_dbm(const PathLossConfig& c, double distance_m) {
  const double d = std::max(distance_m, kNearest_m);
  return c.tx_power_dbm - c.loss_at_1m_db - 10 * c.exponent * std::log10(d);
}

double frame_loss(const PathLossConfig& c, double signal_dbm) {
  return 1 / (1 + kOddsAtSensitivity * std::exp((signal_dbm - c.sensitivity_dbm) / c.fade_db));
}

double message_loss(const ChannelConfig& c, double frame_loss, std::size_t bytes) {
  const std::size_t frames = std::max<std::size_t>(1, (bytes + c.frame_bytes - 1) / c.frame_bytes);
  return 1 - (1 - c.loss) * std::pow(1 - frame_loss, static_cast<double>(frames));
}

double forecast(const ChannelConfig& c, double distance_m, int walls) {
  if (!c.path_loss) {
    return distance_m <= c.range_m && (walls == 0 || !c.line_of_sight) ? 1 - c.loss : 0;
  }
  const PathLossConfig& p = *c.path_loss;
  const double mean_dbm = open_signal_dbm(p, distance_m) - walls * p.wall_loss_db;
  const double sigma_db = std::hypot(p.shadowing_db, p.asymmetry_db);
  // The mean over a normal deviation, by a sum over ±4 σ.
  constexpr int kSteps = 32;
  double sum = 0, weights = 0;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double z = 4.0 * i / kSteps, weight = std::exp(-z * z / 2);
    sum += weight * (1 - frame_loss(p, mean_dbm + z * sigma_db));
    weights += weight;
  }
  return (1 - c.loss) * sum / weights;
}

double dependable_range_m(const ChannelConfig& c) {
  if (!c.path_loss) return c.range_m;
  const double wanted = kDependable * (1 - c.loss);
  double low = kNearest_m, high = 100'000;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(low * high);
    (forecast(c, middle, 0) >= wanted ? low : high) = middle;
  }
  return low;
}

}  // namespace muster::radio
