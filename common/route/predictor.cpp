#include "common/route/predictor.h"

#include <algorithm>

namespace muster::route {

double predict_remaining_s(const PredictorInput& in) {
  if (!(in.elapsed_s > 0)) return kFirstSlice_s;
  if (!(in.explored_m3 > 0) || !(in.volume_m3 > 0)) return kMaxRemaining_s;

  double total_s = std::max(in.volume_m3 / in.explored_m3, 1.0) * in.elapsed_s;
  if (in.results_received >= kFewResults) {
    // There are never more results than areas; a late correction of the count must not shorten the
    // estimate.
    total_s *= std::max(1.0, static_cast<double>(in.features_found) / in.results_received);
  }
  return std::clamp(total_s - in.elapsed_s, kMinRemaining_s, kMaxRemaining_s);
}

}  // namespace muster::route
