#pragma once

#include <optional>
#include <string>

#include "deploy/muster/report_data.h"

namespace muster::command {

/// A rectangle of the world in one of the two views: u to the right, v upwards, metres.
struct ViewFrame {
  double u0 = 0, u1 = 1, v0 = 0, v1 = 1;
  double width() const { return u1 - u0; }
  double height() const { return v1 - v0; }
};

/// The site drawn twice, as an architect would: the plan (x, y from above) and the elevation (x, z
/// from the south). Both share x. Pictures are PNG data URIs, one pixel per voxel, transparent
/// where nothing is known; empty without a map.
struct SiteViews {
  ViewFrame plan, elevation;
  std::string plan_light, plan_dark, elevation_light, elevation_dark;
};

/// Draws `<dir>/map.bt`, framed so that tracks and features fit too. A map that is missing or
/// damaged is noted in `run.notes`. Returns nullopt when there is nothing at all to frame.
std::optional<SiteViews> draw_site(RunData& run);

}  // namespace muster::command
