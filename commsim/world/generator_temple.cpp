#include <algorithm>
#include <cmath>

#include "commsim/world/generator_parts.h"

namespace muster::world::parts {
namespace {

constexpr double kColumnRadius = 0.22;

/// Columns on the edge of a rectangle, `bays_x` × `bays_y` apart.
void colonnade(Solids& out, double width, double depth, int bays_x, int bays_y, double z0,
               double z1) {
  for (int i = 0; i <= bays_x; ++i) {
    for (int j = 0; j <= bays_y; ++j) {
      if (i != 0 && i != bays_x && j != 0 && j != bays_y) continue;
      const Vec2 at(width * (static_cast<double>(i) / bays_x - 0.5),
                    depth * (static_cast<double>(j) / bays_y - 0.5));
      out.column(at, kColumnRadius, z0, z1);
      out.column(at, kColumnRadius + 0.1, z0, z0 + 0.25);
    }
  }
}

/// Tie beams between the columns' heads, and the brackets that carry the eaves.
void entablature(Solids& out, double width, double depth, double z) {
  const double x = width / 2, y = depth / 2, t = 0.13;
  for (const double side : {-1.0, 1.0}) {
    out.box({-x, side * y - t, z - 0.45}, {x, side * y + t, z});
    out.box({side * x - t, -y, z - 0.45}, {side * x + t, y, z});
  }
  out.frustum(rectangle(width + 0.3, depth + 0.3), z, rectangle(width + 1.1, depth + 1.1),
              z + 0.45);
}

/// A hipped roof with its ridge beam and the ornaments at its ends; returns the height of the
/// ridge.
double hall_roof(Solids& out, double width, double depth, double z, double rise, double overhang,
                 double lift) {
  const double ridge = std::max(0.6, width - 0.75 * depth);
  out.swept_roof(rectangle(width + 2 * overhang, depth + 2 * overhang), rectangle(ridge, 0.4), z,
                 rise, lift);
  const double top = z + rise + 0.25;
  out.box({-ridge / 2, -0.2, top - 0.2}, {ridge / 2, 0.2, top + 0.15});
  for (const double side : {-1.0, 1.0}) {
    const double x = side * ridge / 2;
    out.frustum(rectangle(0.5, 0.4, {x, 0}), top - 0.2, rectangle(0.2, 0.2, {x + side * 0.2, 0}),
                top + 0.5);
  }
  return top;
}

/// Doors and lattice windows standing 0.12 m proud of a wall at y, between z0 and z1.
void panels(Solids& out, double width, double y, double z0, double z1) {
  const int n = std::max(1, static_cast<int>(width / 1.6));
  for (int i = 0; i < n; ++i) {
    const double x = width * ((i + 0.5) / n - 0.5);
    out.box({x - 0.5, y - 0.12, z0}, {x + 0.5, y + 0.12, z1});
  }
}

}  // namespace

void hall(YamlMap& map, Solids& out) {
  const double width = positive(map, "width", 12), depth = positive(map, "depth", 8);
  const int bays_x = count(map, "bays_x", 4, 1, 20), bays_y = count(map, "bays_y", 3, 1, 20);
  const double height = positive(map, "columns", 3.2), rise = positive(map, "rise", 2.2);
  const double overhang = positive(map, "overhang", 1.3);
  double terrace = 0.8, verandah = 2.1, lift = 0.5;
  int tiers = count(map, "tiers", 1, 1, 2);
  bool open = false;
  map.read("terrace", terrace);
  map.read("verandah", verandah);
  map.read("lift", lift);
  map.read("open", open);
  if (width / bays_x < 2.1 || depth / bays_y < 2.1) {
    map.fail("bays_x", "columns would be less than 2.1 m apart");
  }
  const double core_x = width - 2 * verandah, core_y = depth - 2 * verandah;
  if (!open && std::min(core_x, core_y) < 0.5) map.fail("verandah", "leaves no room for the hall");

  if (terrace > 0) {
    out.box({-width / 2 - 1.1, -depth / 2 - 1.1, 0}, {width / 2 + 1.1, depth / 2 + 1.1, terrace});
    steps(out, std::min(4.0, width / 2), -depth / 2 - 1.1, terrace);
  }
  const double top = terrace + height;
  colonnade(out, width, depth, bays_x, bays_y, terrace, top);
  entablature(out, width, depth, top);
  if (!open) {
    out.box({-core_x / 2, -core_y / 2, terrace}, {core_x / 2, core_y / 2, top + 0.1});
    panels(out, core_x - 0.4, -core_y / 2, terrace, top - 0.7);
    panels(out, core_x - 0.4, core_y / 2, terrace + 0.9, top - 0.7);
  }
  if (tiers == 1) {
    hall_roof(out, width, depth, top + 0.3, rise, overhang, lift);
    return;
  }
  const double inner_x = width * 0.72, inner_y = depth * 0.66;
  out.swept_roof(rectangle(width + 2 * overhang, depth + 2 * overhang),
                 rectangle(inner_x - 0.2, inner_y - 0.2), top + 0.3, 0.55 * rise, lift);
  const double upper = top + 0.55 + 0.55 * rise;
  out.box({-inner_x / 2, -inner_y / 2, upper - 0.6}, {inner_x / 2, inner_y / 2, upper + 1});
  panels(out, inner_x - 0.4, -inner_y / 2, upper + 0.1, upper + 0.8);
  entablature(out, inner_x, inner_y, upper + 0.8);
  hall_roof(out, inner_x, inner_y, upper + 1.1, rise, overhang, lift);
}

void pagoda(YamlMap& map, Solids& out) {
  const int sides = count(map, "sides", 8, 4, 12), storeys = count(map, "storeys", 4, 2, 13);
  const double radius = positive(map, "radius", 2.6), verandah = positive(map, "verandah", 2);
  const double ground = positive(map, "ground_floor", 3.2), storey = positive(map, "storey", 2.4);
  const double overhang = positive(map, "overhang", 1.2), taper = positive(map, "taper", 0.84);
  double terrace = 0.8;
  map.read("terrace", terrace);
  if (taper > 1) map.fail("taper", "must be at most 1");

  const double outer = radius + verandah;
  out.prism(polygon(sides, outer + 1), 0, terrace);
  for (int i = 0; i < 4; ++i) {
    const Solids::Frame here = out.frame();
    out.set_frame(out.nested({Vec3::Zero(), i * std::numbers::pi / 2}));
    steps(out, 2, -outer - 1, terrace);
    out.set_frame(here);
  }
  double z = terrace + ground;
  for (const Vec2& p : polygon(sides, outer)) {
    out.column(p, kColumnRadius, terrace, z);
    out.column(p, kColumnRadius + 0.1, terrace, terrace + 0.25);
  }
  out.prism(polygon(sides, radius), terrace, z + 0.1);
  out.frustum(polygon(sides, outer + 0.2), z - 0.35, polygon(sides, outer + 0.6), z + 0.2);

  double wall = radius, eaves = outer + overhang;
  for (int i = 0; i < storeys; ++i) {
    const bool last = i + 1 == storeys;
    const double next = wall * taper, rise = last ? 0.75 * storey : 0.45 * storey;
    out.swept_roof(polygon(sides, eaves), polygon(sides, last ? 0.2 : next - 0.05), z + 0.1, rise,
                   0.35, 0.2);
    z += 0.3 + rise;
    if (last) break;
    wall = next;
    const double wall_top = z + 0.55 * storey;
    out.prism(polygon(sides, wall + 0.45), z - 0.25, z + 0.05);  // balcony
    out.prism(polygon(sides, wall), z - 0.6, wall_top + 0.2);
    out.frustum(polygon(sides, wall + 0.1), wall_top - 0.2, polygon(sides, wall + 0.5),
                wall_top + 0.15);
    for (int k = 0; k < sides; k += 2) {  // windows
      const Solids::Frame here = out.frame();
      out.set_frame(out.nested({Vec3::Zero(), k * 2 * std::numbers::pi / sides}));
      out.box({-0.4, -wall - 0.1, z + 0.2}, {0.4, -wall + 0.2, wall_top - 0.3});
      out.set_frame(here);
    }
    z = wall_top;
    eaves = wall + overhang;
  }
  for (const double r : {0.45, 0.36, 0.28, 0.2}) {  // the spire's rings
    out.frustum(polygon(8, r * 0.6), z - 0.05, polygon(8, r), z + 0.2);
    out.frustum(polygon(8, r), z + 0.2, polygon(8, r * 0.5), z + 0.36);
    z += 0.33;
  }
  out.frustum(polygon(8, 0.12), z - 0.1, polygon(8, 0.03), z + 0.6);
}

void paifang(YamlMap& map, Solids& out) {
  const double width = positive(map, "width", 8), height = positive(map, "height", 4);
  const double x[] = {-width / 2, -width / 5, width / 5, width / 2};
  if (width / 2 - width / 5 < 2.2) map.fail("width", "the side passages would be too narrow");
  for (const double at : x) {
    out.column({at, 0}, 0.25, 0, height, 10);
    out.box({at - 0.4, -0.6, 0}, {at + 0.4, 0.6, 0.6});
  }
  const double high = height + 1;
  out.column({x[1], 0}, 0.25, 0, high, 10);
  out.column({x[2], 0}, 0.25, 0, high, 10);
  const auto bay = [&](double from, double to, double z, double rise) {
    const Solids::Frame here = out.frame();
    out.box({from, -0.15, z - 1.1}, {to, 0.15, z - 0.7});
    out.box({from, -0.1, z - 0.7}, {to, 0.1, z});
    out.set_frame(out.nested({{(from + to) / 2, 0, 0}, 0}));
    const double length = to - from;
    out.swept_roof(rectangle(length + 0.8, 2.2), rectangle(length, 0.25), z, rise, 0.3, 0.18);
    out.set_frame(here);
  };
  bay(x[0], x[1], height, 0.7);
  bay(x[2], x[3], height, 0.7);
  bay(x[1], x[2], high, 0.9);
}

void gallery(YamlMap& map, Solids& out) {
  const double length = positive(map, "length", 12), depth = positive(map, "depth", 3);
  const double height = positive(map, "height", 3), rise = positive(map, "rise", 1.1);
  bool back_wall = false;
  map.read("back_wall", back_wall);
  if (depth < 2.4) map.fail("depth", "the gallery would be too narrow to fly through");
  const int bays = std::max(1, static_cast<int>(length / 2.8));
  for (int i = 0; i <= bays; ++i) {
    const double at = length * (static_cast<double>(i) / bays - 0.5);
    out.column({at, -depth / 2}, 0.18, 0, height);
    if (!back_wall) out.column({at, depth / 2}, 0.18, 0, height);
  }
  if (back_wall) {
    out.box({-length / 2, depth / 2 - 0.2, 0}, {length / 2, depth / 2 + 0.2, height});
  }
  for (const double y : {-depth / 2, depth / 2}) {
    out.box({-length / 2 - 0.2, y - 0.12, height - 0.3},
            {length / 2 + 0.2, y + 0.12, height + 0.1});
  }
  out.gable_roof(depth, length, height, rise, 0.6, true);
}

}  // namespace muster::world::parts
