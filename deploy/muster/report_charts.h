#pragma once

#include <optional>
#include <string>

#include "deploy/muster/report_data.h"
#include "deploy/muster/report_map.h"

/// The pictures of report.html, as HTML fragments. Shapes are SVG stretched to the width at hand,
/// text is HTML, so that it keeps its size on every screen. Everything is readable without scripts;
/// scripts add the moving cursor.
namespace muster::command {

/// Plan and elevation with tracks, features and robots.
std::string site_figure(const RunData& run, const SiteViews& views);
/// Features found, inspected and delivered over time.
std::string features_figure(const RunData& run);
/// One row per robot: what it did when, and below that whom it heard.
std::string timeline_figure(const RunData& run);
/// What the script needs, as JSON: tracks thinned to a bounded size, and features.
std::string playback_json(const RunData& run, const std::optional<SiteViews>& views);

}  // namespace muster::command
