#include <cmath>

#include "commsim/world/generator_parts.h"

namespace muster::world::parts {

double positive(YamlMap& map, const std::string& key, double fallback) {
  double v = fallback;
  map.read(key, v);
  if (v <= 0) map.fail(key, "must be greater than 0");
  return v;
}

int count(YamlMap& map, const std::string& key, int fallback, int low, int high) {
  int v = fallback;
  map.read(key, v);
  if (v < low || v > high) {
    map.fail(key, "must be between " + std::to_string(low) + " and " + std::to_string(high));
  }
  return v;
}

void box(YamlMap& map, Solids& out) {
  Vec3 size = Vec3::Ones();
  map.require("size", size);
  if ((size.array() <= 0).any()) map.fail("size", "must be greater than 0 in x, y and z");
  out.box({-size.x() / 2, -size.y() / 2, 0}, {size.x() / 2, size.y() / 2, size.z()});
}

void column(YamlMap& map, Solids& out) {
  const double radius = positive(map, "radius", 0.25), height = positive(map, "height", 3);
  const int sides = count(map, "sides", 12, 3, 64);
  out.column({0, 0}, radius, 0, height, sides);
}

void cone(YamlMap& map, Solids& out) {
  const double radius = positive(map, "radius", 1), height = positive(map, "height", 2);
  const int sides = count(map, "sides", 16, 3, 64);
  const Outline base = polygon(sides, radius);
  out.frustum(base, 0, scaled(base, 0.02), height);
}

void gable_roof(YamlMap& map, Solids& out) {
  const double width = positive(map, "width", 6), length = positive(map, "length", 8);
  const double rise = positive(map, "rise", 2), overhang = positive(map, "overhang", 0.6);
  bool along_x = true;
  map.read("ridge_along_x", along_x);
  out.gable_roof(width, length, 0, rise, overhang, along_x);
}

void hip_roof(YamlMap& map, Solids& out) {
  const double width = positive(map, "width", 8), depth = positive(map, "depth", 6);
  const double rise = positive(map, "rise", 2), overhang = positive(map, "overhang", 0.8);
  double lift = 0;
  map.read("lift", lift);
  const double ridge = std::max(0.3, width - depth);
  out.swept_roof(rectangle(width + 2 * overhang, depth + 2 * overhang), rectangle(ridge, 0.3), 0,
                 rise, lift);
}

void arch(YamlMap& map, Solids& out) {
  const double width = positive(map, "width", 6), depth = positive(map, "depth", 2);
  const double height = positive(map, "height", 5), opening = positive(map, "opening", 2.4);
  const double spring = positive(map, "spring", 2);
  if (opening >= width) map.fail("opening", "must be narrower than width");
  if (spring + opening / 2 >= height) map.fail("spring", "the vault does not fit below height");
  out.arch(width, depth, height, opening, spring);
}

void wall(YamlMap& map, Solids& out) {
  const double length = positive(map, "length", 6), height = positive(map, "height", 3);
  const double thickness = positive(map, "thickness", 0.4);
  std::vector<Eigen::Vector4d> openings;
  for (YamlMap& item : map.list("openings")) {
    double x = 0, sill = 0;
    item.require("x", x);
    item.read("sill", sill);
    const double width = positive(item, "width", 1.8), high = positive(item, "height", 2.2);
    item.finish();
    if (std::abs(x) + width / 2 > length / 2) item.fail("x", "the opening is wider than the wall");
    openings.emplace_back(x - width / 2, sill, x + width / 2, sill + high);
  }
  out.wall(length, thickness, 0, height, openings);
}

void steps(Solids& out, double width, double front_y, double height) {
  const int n = std::max(1, static_cast<int>(std::lround(height / 0.2)));
  for (int i = 1; i < n; ++i) {
    const double z = height * (n - i) / n;
    out.box({-width / 2, front_y - 0.35 * i, 0}, {width / 2, front_y - 0.35 * (i - 1), z});
  }
}

void stairs(YamlMap& map, Solids& out) {
  const double width = positive(map, "width", 2), height = positive(map, "height", 1);
  steps(out, width, 0, height);
}

void tree(YamlMap& map, Solids& out) {
  const double height = positive(map, "height", 5), radius = positive(map, "radius", 1.6);
  const double low = height - 1.6 * radius;
  if (low < 1) map.fail("height", "the crown would touch the ground");
  out.column({0, 0}, 0.2, 0, low + 0.3, 8);
  std::vector<Ring> crown;
  for (int k = 0; k <= 6; ++k) {
    const double a = std::numbers::pi * (k + 0.35) / 6.7;
    Ring ring;
    for (const Vec2& p : polygon(10, radius * std::sin(a))) {
      ring.emplace_back(p.x(), p.y(), low + 0.8 * radius * (1 - std::cos(a)));
    }
    crown.push_back(ring);
  }
  out.loft(crown);
}

void merlons(Solids& out, double x0, double x1, double y, double z, double thickness) {
  const int n = std::max(1, static_cast<int>((x1 - x0) / 2.4));
  const double pitch = (x1 - x0) / n;
  out.box({x0, y - thickness / 2, z}, {x1, y + thickness / 2, z + 0.4});
  for (int i = 0; i < n; ++i) {
    const double x = x0 + (i + 0.5) * pitch;
    out.box({x - pitch / 4, y - thickness / 2, z + 0.4}, {x + pitch / 4, y + thickness / 2, z + 1});
  }
}

}  // namespace muster::world::parts
