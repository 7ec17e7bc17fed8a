#pragma once

#include <cstdint>

namespace muster::route {

/// What an explorer knows of its region when it agrees on the next meeting with the station.
struct PredictorInput {
  double volume_m3 = 0;                ///< V_B: the whole region
  double explored_m3 = 0;              ///< V_B^m: known so far
  std::uint32_t features_found = 0;    ///< |F|: areas of interest found so far
  std::uint32_t results_received = 0;  ///< |S|: of those, with an inspection result in hand
  double elapsed_s = 0;                ///< t^e: since the exploration of this region began
};

/// The paper leaves t^e to the user; its authors' code explores 60 s before the first prediction,
/// and keeps a prediction within these bounds.
inline constexpr double kFirstSlice_s = 60;
inline constexpr double kMinRemaining_s = 50;
inline constexpr double kMaxRemaining_s = 600;
/// Below this |S| the factor |F|/|S| of (9) is noise (1 result of 30 areas says "thirty times as
/// long").
inline constexpr std::uint32_t kFewResults = 3;

/// Seconds until the region is explored and its results are in, from now: S0 eq. (9),
///
///     t = (V_B / |S|) · (|F| / V_B^m) · t^e        or, when |S| is 0 (here: below kFewResults), t
///     = V_B · t^e / V_B^m
///
/// read as a duration since the exploration began (the paper uses it as an instant), less what has
/// passed, within [50, 600] s. With nothing elapsed: the first slice.
double predict_remaining_s(const PredictorInput& input);

}  // namespace muster::route
