#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commsim/world/scene.h"

namespace muster::command {

struct RenderOptions {
  int width = 1600, height = 1000;
  double azimuth_deg = -60;   ///< where the camera stands, from +x towards +y
  double elevation_deg = 32;  ///< how far above the horizon
  double zoom = 1;
  std::optional<Vec3> target;  ///< looked at; the middle of the boxes (or the scene) when absent
};

/// Writes a shaded picture of `scene` from obliquely above as a PNG; with a mission also its boxes,
/// starts and features. Throws Failure when the file cannot be written.
void render(const world::Scene& scene, const mission::Mission* mission,
            const std::vector<world::Feature>& features, const std::string& file,
            const RenderOptions& options);

}  // namespace muster::command
