#include <algorithm>
#include <cmath>
#include <string>

#include "commsim/world/generator_parts.h"

namespace muster::world::parts {
namespace {

/// Framed windows along x on a wall at y, one row for each floor above `z0`.
void windows(Solids& out, double width, double y, double z0, double z1) {
  const int n = std::max(1, static_cast<int>(width / 2.2));
  for (int floor = 0; z0 + 2.8 * floor + 2.2 <= z1 + 1e-9; ++floor) {
    const double z = z0 + 2.8 * floor;
    for (int i = 0; i < n; ++i) {
      const double x = width * ((i + 0.5) / n - 0.5);
      out.box({x - 0.5, y - 0.1, z + 0.8}, {x + 0.5, y + 0.1, z + 2.1});
      out.box({x - 0.65, y - 0.22, z + 0.68}, {x + 0.65, y + 0.22, z + 0.82});
    }
  }
}

/// A square of merlons.
void crown(Solids& out, double half, double z) {
  for (const double side : {-1.0, 1.0}) {
    merlons(out, -half, half, side * (half - 0.25), z, 0.5);
  }
  const Solids::Frame here = out.frame();
  out.set_frame(out.nested({Vec3::Zero(), std::numbers::pi / 2}));
  for (const double side : {-1.0, 1.0}) {
    merlons(out, -half + 0.5, half - 0.5, side * (half - 0.25), z, 0.5);
  }
  out.set_frame(here);
}

/// Four corner piers and what they carry: one can fly through.
void belfry(Solids& out, double half, double z, double height) {
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const Vec2 c(sx * (half - 0.3), sy * (half - 0.3));
      out.prism(rectangle(0.6, 0.6, c), z, z + height);
    }
  }
  out.prism(rectangle(2 * half + 0.4, 2 * half + 0.4), z + height - 0.05, z + height + 0.35);
}

}  // namespace

void house(YamlMap& map, Solids& out) {
  const double width = positive(map, "width", 8), depth = positive(map, "depth", 8);
  const double height = positive(map, "height", 6), rise = positive(map, "rise", 3);
  const double overhang = positive(map, "overhang", 0.6);
  bool ridge_along_x = true, chimney = true, dormer = false;
  double jetty = 0, passage = 0;
  map.read("ridge_along_x", ridge_along_x);
  map.read("chimney", chimney);
  map.read("dormer", dormer);
  map.read("jetty", jetty);
  map.read("passage", passage);

  if (passage > 0) {
    if (passage < 2 || passage + 2 > width) map.fail("passage", "must leave walls and be ≥ 2 m");
    if (1.6 + passage / 2 + 0.4 > height) map.fail("passage", "the vault is higher than the house");
    out.arch(width, depth, height, passage, 1.6);
  } else {
    out.box({-width / 2, -depth / 2, 0}, {width / 2, depth / 2, height});
    out.box({-0.6, -depth / 2 - 0.15, 0}, {0.6, -depth / 2 + 0.1, 2.2});  // the door
  }
  const double first = passage > 0 ? 2.8 : 0.0;
  windows(out, width - 0.8, depth / 2, first, height);
  if (jetty > 0) {
    out.box({-width / 2, -depth / 2 - jetty, 3}, {width / 2, -depth / 2 + 0.1, height});
    windows(out, width - 0.8, -depth / 2 - jetty, 2.8, height);
  } else {
    windows(out, width - 0.8, -depth / 2, 2.8, height);
  }
  const double whole = depth + jetty, middle = -jetty / 2;
  const Solids::Frame here = out.frame();
  out.set_frame(out.nested({{0, middle, 0}, 0}));
  const double across = ridge_along_x ? whole : width, along = ridge_along_x ? width : whole;
  out.gable_roof(across, along, height, rise, overhang, ridge_along_x);
  if (chimney) {
    const Vec2 at = ridge_along_x ? Vec2(width / 4, whole / 6) : Vec2(width / 6, whole / 4);
    out.prism(rectangle(0.7, 0.7, at), height, height + rise + 0.9);
    out.prism(rectangle(0.9, 0.9, at), height + rise + 0.7, height + rise + 0.9);
  }
  if (dormer && ridge_along_x) {
    const double y0 = -whole / 2 + 0.4, z0 = height + 0.2, z1 = height + 0.55 * rise;
    out.box({-0.8, y0, z0}, {0.8, 0, z1});
    out.extrude({{-1.05, z1}, {1.05, z1}, {0, z1 + 0.8}}, false, y0 - 0.3, 0);
  }
  out.set_frame(here);
}

void tower(YamlMap& map, Solids& out) {
  const double radius = positive(map, "radius", 2.5), height = positive(map, "height", 10);
  const int sides = count(map, "sides", 4, 4, 24);
  std::string top = "battlements";
  map.read("top", top);
  const double roof = positive(map, "roof", 3);
  out.frustum(polygon(sides, radius + 0.5), 0, polygon(sides, radius), std::min(2.0, height / 3));
  out.prism(polygon(sides, radius), 0, height);
  out.frustum(polygon(sides, radius), height - 1.2, polygon(sides, radius + 0.45), height - 0.5);
  out.prism(polygon(sides, radius + 0.45), height - 0.5, height);
  for (int floor = 0; 2.4 + 3.2 * floor + 2.5 < height; ++floor) {
    const double z = 2.4 + 3.2 * floor;
    out.box({-0.35, -radius - 0.12, z}, {0.35, -radius + 0.3, z + 1.2});
    out.box({-0.35, radius - 0.3, z}, {0.35, radius + 0.12, z + 1.2});
  }
  if (top == "battlements") {
    if (sides == 4) {
      crown(out, radius + 0.45, height);
    } else {
      const Outline edge = polygon(sides, radius + 0.25);
      for (std::size_t i = 0; i < edge.size(); i += 2) {
        out.prism(rectangle(0.6, 0.6, edge[i]), height, height + 0.9);
      }
    }
  } else if (top == "cone") {
    const Outline eaves = polygon(sides, radius + 0.9);
    out.swept_roof(eaves, scaled(eaves, 0.04), height, roof, 0, 0.15);
  } else if (top == "belfry") {
    if (sides != 4 || radius < 1.45) map.fail("top", "a belfry needs 4 sides and radius ≥ 1.45");
    belfry(out, radius, height, 2.6);
    const Outline eaves = polygon(4, radius + 0.6);
    out.swept_roof(eaves, scaled(eaves, 0.05), height + 2.85, roof, 0, 0.15);
  } else {
    map.fail("top", "'" + top + "' is not one of battlements, cone, belfry");
  }
}

void church(YamlMap& map, Solids& out) {
  const double width = positive(map, "width", 9), length = positive(map, "length", 18);
  const double height = positive(map, "height", 8), rise = positive(map, "rise", 5);
  const double spire = positive(map, "tower", 15);
  // Nave along y with the tower at its front (−y) end, lower aisles and a round apse.
  out.box({-width / 2, -length / 2, 0}, {width / 2, length / 2, height});
  out.gable_roof(width, length, height, rise, 0.5, false);
  const double aisle = 2.6, aisle_top = height * 0.55;
  for (const double side : {-1.0, 1.0}) {
    const double in = side * (width / 2 - 0.1), ext = side * (width / 2 + aisle);
    out.extrude({{in, 0}, {ext, 0}, {ext, aisle_top - 1.1}, {in, aisle_top + 0.4}}, false,
                -length / 2 + 1, length / 2 - 2);
    const int n = std::max(2, static_cast<int>(length / 4.2));
    for (int i = 0; i < n; ++i) {  // buttresses
      const double y = (length - 5) * (static_cast<double>(i) / (n - 1) - 0.5) - 0.5;
      out.extrude({{ext - side * 0.1, 0},
                   {ext + side * 0.9, 0},
                   {ext + side * 0.9, 1.6},
                   {ext - side * 0.1, aisle_top - 1.3}},
                  false, y - 0.35, y + 0.35);
    }
  }
  const Solids::Frame here = out.frame();
  out.set_frame(out.nested({{0, length / 2, 0}, 0}));
  const Outline apse = polygon(12, width * 0.36);
  out.prism(apse, 0, height * 0.7);
  const Outline eaves = scaled(apse, 1.12);
  out.swept_roof(eaves, scaled(eaves, 0.04), height * 0.7, rise * 0.55, 0, 0.15);
  out.set_frame(out.nested({{0, -length - 1.8, 0}, 0}));
  const double half = 2.3;
  out.prism(rectangle(2 * half, 2 * half), 0, spire);
  for (int z = 4; z < spire; z += 4) {
    out.prism(rectangle(2 * half + 0.4, 2 * half + 0.4), z - 0.15, z + 0.15);  // cornices
  }
  out.arch(2 * half + 0.8, 2 * half + 0.5, 3.4, 1.8, 1.6);
  belfry(out, half, spire, 3);
  const Outline top = rectangle(2 * half + 0.8, 2 * half + 0.8);
  out.swept_roof(top, scaled(top, 0.04), spire + 3.2, spire * 0.42, 0, 0.15);
  out.set_frame(here);
}

void rampart(YamlMap& map, Solids& out) {
  const double length = positive(map, "length", 20), height = positive(map, "height", 6);
  const double thickness = positive(map, "thickness", 2.6);
  double gate = 0;
  map.read("gate", gate);
  // A battered wall along x, its outside towards −y, with a walk on top behind the merlons.
  const double x = length / 2, y = thickness / 2;
  if (gate > 0) {
    if (gate < 2 || gate + 2 > length) map.fail("gate", "must leave walls and be ≥ 2 m");
    if (1.8 + gate / 2 + 0.4 > height) map.fail("gate", "the vault is higher than the wall");
    out.arch(length, thickness, height, gate, 1.8);
  } else {
    out.extrude({{-y - 0.5, 0}, {y, 0}, {y, height}, {-y, height}}, true, -x, x);
    const int n = std::max(1, static_cast<int>(length / 6));
    for (int i = 0; i < n; ++i) {
      const double at = length * ((i + 0.5) / n - 0.5);
      out.extrude(
          {{-y - 1.1, 0}, {-y + 0.2, 0}, {-y + 0.2, height - 0.8}, {-y - 0.3, height - 0.8}}, true,
          at - 0.5, at + 0.5);
    }
  }
  merlons(out, -x, x, -y + 0.25, height, 0.5);
  out.box({-x, y - 0.3, height}, {x, y, height + 0.5});
}

}  // namespace muster::world::parts
