#include "deploy/muster/report_map.h"

#include <octomap/OcTree.h>
#include <png.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <vector>

namespace muster::command {
namespace {

constexpr double kMargin_m = 1.0;
/// A picture wider than this is drawn with several voxels per pixel.
constexpr int kMaxPixels = 900;
constexpr float kNothing = -std::numeric_limits<float>::infinity();

using Colour = std::array<double, 3>;
/// From far to near, and what is known to be free.
struct Palette {
  Colour far, near;
  std::array<std::uint8_t, 4> free;
};
constexpr Palette kLight{{214, 217, 212}, {116, 124, 127}, {255, 255, 255, 170}};
constexpr Palette kDark{{47, 53, 57}, {168, 176, 178}, {255, 255, 255, 10}};

/// What a viewer sees along one axis: per pixel how near the nearest surface is (larger is nearer),
/// and whether the line of sight was looked at, at all.
class Relief {
 public:
  Relief(const ViewFrame& frame, double pixel_m)
      : frame_(frame),
        pixel_m_(pixel_m),
        columns(std::max(1, static_cast<int>(std::ceil(frame.width() / pixel_m - 1e-6)))),
        rows(std::max(1, static_cast<int>(std::ceil(frame.height() / pixel_m - 1e-6)))),
        near_(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), kNothing),
        known_(near_.size(), false) {}

  /// A cube of side `size_m` around (u, v).
  void add(double u, double v, double size_m, bool occupied, double nearness) {
    const auto column = [&](double x) {
      return static_cast<int>(std::floor((x - frame_.u0) / pixel_m_ + 1e-6));
    };
    const auto row = [&](double y) {
      return static_cast<int>(std::floor((frame_.v1 - y) / pixel_m_ + 1e-6));
    };
    const double h = size_m / 2;
    const int c1 = std::min(columns - 1, column(u + h - 1e-3)),
              r1 = std::min(rows - 1, row(v - h + 1e-3));
    for (int r = std::max(0, row(v + h - 1e-3)); r <= r1; ++r) {
      for (int c = std::max(0, column(u - h + 1e-3)); c <= c1; ++c) {
        known_[index(c, r)] = true;
        if (occupied)
          near_[index(c, r)] = std::max(near_[index(c, r)], static_cast<float>(nearness));
      }
    }
  }

  bool surface(int c, int r) const { return near_[index(c, r)] != kNothing; }
  bool known(int c, int r) const { return known_[index(c, r)]; }
  /// Outside and where nothing is: as near as `otherwise`.
  double near(int c, int r, double otherwise) const {
    if (c < 0 || r < 0 || c >= columns || r >= rows || !surface(c, r)) return otherwise;
    return near_[index(c, r)];
  }
  std::pair<double, double> range() const {
    double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
    for (const float n : near_) {
      if (n == kNothing) continue;
      low = std::min<double>(low, n);
      high = std::max<double>(high, n);
    }
    return {low, std::max(high, low + 1)};
  }

 private:
  std::size_t index(int c, int r) const {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(c);
  }
  ViewFrame frame_;
  double pixel_m_;

 public:
  const int columns, rows;

 private:
  std::vector<float> near_;
  std::vector<bool> known_;
};

/// Light from the upper left, and less of it in the depth between things that stand nearer.
double light_at(const Relief& relief, int c, int r) {
  const double here = relief.near(c, r, 0);
  const auto step = [&](int dc, int dr) {
    return std::clamp(relief.near(c + dc, r + dr, here) - here, -0.6, 0.6);
  };
  const double slope = (step(1, 0) - step(-1, 0)) + (step(0, 1) - step(0, -1));
  double depth = 0;
  for (int dr = -3; dr <= 3; ++dr) {
    for (int dc = -3; dc <= 3; ++dc)
      depth += std::clamp(relief.near(c + dc, r + dr, here) - here, 0.0, 2.0);
  }
  return std::clamp(1.0 - 0.16 * slope, 0.8, 1.18) * (1.0 - 0.28 * depth / (48 * 2.0));
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = static_cast<std::uint32_t>(bytes[i]) << 16;
    if (i + 1 < bytes.size()) three |= static_cast<std::uint32_t>(bytes[i + 1]) << 8;
    if (i + 2 < bytes.size()) three |= bytes[i + 2];
    text += kDigits[three >> 18];
    text += kDigits[(three >> 12) & 63];
    text += i + 1 < bytes.size() ? kDigits[(three >> 6) & 63] : '=';
    text += i + 2 < bytes.size() ? kDigits[three & 63] : '=';
  }
  return text;
}

std::string png_uri(const std::vector<std::uint8_t>& rgba, int columns, int rows) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(columns);
  image.height = static_cast<png_uint_32>(rows);
  image.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = 0;
  if (!png_image_write_to_memory(&image, nullptr, &size, 0, rgba.data(), 0, nullptr)) return "";
  std::vector<std::uint8_t> png(size);
  if (!png_image_write_to_memory(&image, png.data(), &size, 0, rgba.data(), 0, nullptr)) return "";
  png.resize(size);
  return "data:image/png;base64," + base64(png);
}

std::string paint(const Relief& relief, const Palette& palette) {
  const auto [low, high] = relief.range();
  std::vector<std::uint8_t> rgba;
  rgba.reserve(static_cast<std::size_t>(relief.columns) * static_cast<std::size_t>(relief.rows) *
               4);
  for (int r = 0; r < relief.rows; ++r) {
    for (int c = 0; c < relief.columns; ++c) {
      if (!relief.surface(c, r)) {
        for (const std::uint8_t v : palette.free)
          rgba.push_back(relief.known(c, r) ? v : std::uint8_t{0});
        continue;
      }
      const double nearness = (relief.near(c, r, low) - low) / (high - low),
                   light = light_at(relief, c, r);
      for (std::size_t i = 0; i < 3; ++i) {
        const double colour = palette.far[i] + (palette.near[i] - palette.far[i]) * nearness;
        rgba.push_back(static_cast<std::uint8_t>(std::clamp(colour * light, 0.0, 255.0)));
      }
      rgba.push_back(255);
    }
  }
  return png_uri(rgba, relief.columns, relief.rows);
}

struct Bounds {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::max());
  Eigen::Vector3d high = Eigen::Vector3d::Constant(std::numeric_limits<double>::lowest());
  void add(const Eigen::Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  bool empty() const { return low.x() > high.x(); }
};

Bounds bounds_of(const RunData& run, const octomap::OcTree* tree) {
  Bounds bounds;
  for (const auto& robot : run.robots) {
    for (const auto& s : robot.track) bounds.add({s.x, s.y, s.z});
  }
  for (const auto& f : run.features) bounds.add({f.x, f.y, f.z});
  if (tree) {
    for (auto leaf = tree->begin_leafs(); leaf != tree->end_leafs(); ++leaf) {
      if (tree->isNodeOccupied(*leaf)) bounds.add({leaf.getX(), leaf.getY(), leaf.getZ()});
    }
  }
  return bounds;
}

/// A `.bt` file. Not `OcTree::readBinary`, which tells stderr what it does, and accepts a file cut
/// short.
std::unique_ptr<octomap::OcTree> read_bt(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  if (!std::getline(file, line) || line.rfind("# Octomap OcTree binary file", 0) != 0)
    return nullptr;
  double resolution_m = 0;
  while (std::getline(file, line) && line != "data") {
    if (line.rfind("res ", 0) == 0) resolution_m = std::strtod(line.c_str() + 4, nullptr);
  }
  if (!file || !(resolution_m > 0)) return nullptr;
  auto tree = std::make_unique<octomap::OcTree>(resolution_m);
  tree->readBinaryData(file);
  return file && tree->size() > 0 ? std::move(tree) : nullptr;
}

std::unique_ptr<octomap::OcTree> read_map(RunData& run) {
  const std::string path = run.dir + "/map.bt";
  std::unique_ptr<octomap::OcTree> tree = read_bt(path);
  if (!tree)
    run.notes.push_back(std::filesystem::exists(path) ? "map.bt is damaged or empty"
                                                      : "map.bt is missing");
  return tree;
}

void paint_views(const octomap::OcTree& tree, SiteViews& views) {
  // Frames start on the map's own grid, so that a voxel is a pixel.
  double pixel_m = tree.getResolution();
  while (views.plan.width() / pixel_m > kMaxPixels) pixel_m *= 2;
  Relief plan(views.plan, pixel_m), elevation(views.elevation, pixel_m);
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const bool occupied = tree.isNodeOccupied(*leaf);
    plan.add(leaf.getX(), leaf.getY(), leaf.getSize(), occupied, leaf.getZ() + leaf.getSize() / 2);
    elevation.add(leaf.getX(), leaf.getZ(), leaf.getSize(), occupied,
                  -leaf.getY() + leaf.getSize() / 2);
  }
  views.plan_light = paint(plan, kLight);
  views.plan_dark = paint(plan, kDark);
  views.elevation_light = paint(elevation, kLight);
  views.elevation_dark = paint(elevation, kDark);
}

}  // namespace

std::optional<SiteViews> draw_site(RunData& run) {
  const std::unique_ptr<octomap::OcTree> tree = read_map(run);
  Bounds bounds = bounds_of(run, tree.get());
  if (bounds.empty()) return std::nullopt;
  const double grid = tree ? tree->getResolution() : 0.2;
  const auto down = [&](double v) { return std::floor((v - kMargin_m) / grid) * grid; };
  const auto up = [&](double v) { return std::ceil((v + kMargin_m) / grid) * grid; };
  SiteViews views;
  views.plan = {down(bounds.low.x()), up(bounds.high.x()), down(bounds.low.y()),
                up(bounds.high.y())};
  views.elevation = {views.plan.u0, views.plan.u1, down(bounds.low.z()), up(bounds.high.z())};
  if (tree) paint_views(*tree, views);
  return views;
}

}  // namespace muster::command
