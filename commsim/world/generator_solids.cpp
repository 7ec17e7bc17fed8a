#include "commsim/world/generator_solids.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace muster::world {
namespace {

Ring at_height(const Outline& outline, double z) {
  Ring ring;
  for (const Vec2& p : outline) ring.emplace_back(p.x(), p.y(), z);
  return ring;
}

/// Points along each side, and how near a corner each one is: 1 at a corner, 0 in the middle.
struct Sampled {
  Outline points;
  std::vector<double> cornerness;
};

Sampled sample(const Outline& outline, int per_side) {
  Sampled s;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 &a = outline[i], &b = outline[(i + 1) % outline.size()];
    for (int k = 0; k < per_side; ++k) {
      const double t = static_cast<double>(k) / per_side;
      s.points.emplace_back(a + t * (b - a));
      s.cornerness.push_back(std::abs(2 * t - 1));
    }
  }
  return s;
}

}  // namespace

Outline rectangle(double width, double depth, const Vec2& c) {
  const double x = width / 2, y = depth / 2;
  return {c + Vec2(-x, -y), c + Vec2(x, -y), c + Vec2(x, y), c + Vec2(-x, y)};
}

Outline polygon(int sides, double apothem) {
  Outline o;
  const double step = 2 * std::numbers::pi / sides;
  const double radius = apothem / std::cos(step / 2);
  for (int i = 0; i < sides; ++i) {
    const double a = -std::numbers::pi / 2 + (i - 0.5) * step;
    o.emplace_back(radius * std::cos(a), radius * std::sin(a));
  }
  return o;
}

Outline scaled(const Outline& outline, double factor) {
  Outline o = outline;
  for (Vec2& p : o) p *= factor;
  return o;
}

Vec3 Solids::to_world(const Vec3& p) const {
  const double c = std::cos(frame_.yaw_rad), s = std::sin(frame_.yaw_rad);
  return frame_.origin + Vec3(c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z());
}

Solids::Frame Solids::nested(const Frame& inner) const {
  return {to_world(inner.origin), frame_.yaw_rad + inner.yaw_rad};
}

void Solids::loft(const std::vector<Ring>& rings) {
  MUSTER_CHECK(rings.size() >= 2);
  const int per_ring = static_cast<int>(rings.front().size());
  const int first = static_cast<int>(mesh_.vertices.size());
  const std::size_t first_triangle = mesh_.triangles.size();
  for (const Ring& ring : rings) {
    MUSTER_CHECK(static_cast<int>(ring.size()) == per_ring);
    for (const Vec3& p : ring) mesh_.vertices.emplace_back(to_world(p).cast<float>());
  }
  const int last_ring = static_cast<int>(rings.size()) - 1;
  for (int k = 0; k < last_ring; ++k) {
    for (int i = 0; i < per_ring; ++i) {
      const int a = first + k * per_ring + i, b = first + k * per_ring + (i + 1) % per_ring;
      mesh_.triangles.emplace_back(a, b, b + per_ring);
      mesh_.triangles.emplace_back(a, b + per_ring, a + per_ring);
    }
  }
  for (const int k : {0, last_ring}) {
    Vec3 center = Vec3::Zero();
    for (const Vec3& p : rings[static_cast<std::size_t>(k)]) center += p / per_ring;
    const int c = static_cast<int>(mesh_.vertices.size());
    mesh_.vertices.emplace_back(to_world(center).cast<float>());
    for (int i = 0; i < per_ring; ++i) {
      const int a = first + k * per_ring + i, b = first + k * per_ring + (i + 1) % per_ring;
      if (k == 0)
        mesh_.triangles.emplace_back(b, a, c);
      else
        mesh_.triangles.emplace_back(a, b, c);
    }
  }
  double volume = 0;
  for (std::size_t t = first_triangle; t < mesh_.triangles.size(); ++t) {
    const auto corner = [&](int i) -> Vec3 {
      return mesh_.vertices[static_cast<std::size_t>(mesh_.triangles[t][i])].cast<double>() -
             frame_.origin;
    };
    volume += corner(0).dot(corner(1).cross(corner(2)));
  }
  if (volume >= 0) return;
  for (std::size_t t = first_triangle; t < mesh_.triangles.size(); ++t) {
    std::swap(mesh_.triangles[t][1], mesh_.triangles[t][2]);
  }
}

void Solids::box(const Vec3& low, const Vec3& high) {
  const Vec2 center = (low + high).head<2>() / 2;
  prism(rectangle(high.x() - low.x(), high.y() - low.y(), center), low.z(), high.z());
}

void Solids::prism(const Outline& outline, double z0, double z1) {
  loft({at_height(outline, z0), at_height(outline, z1)});
}

void Solids::frustum(const Outline& bottom, double z0, const Outline& top, double z1) {
  loft({at_height(bottom, z0), at_height(top, z1)});
}

void Solids::column(const Vec2& center, double radius, double z0, double z1, int sides) {
  Outline o = polygon(sides, radius);
  for (Vec2& p : o) p += center;
  prism(o, z0, z1);
}

void Solids::extrude(const Outline& profile, bool along_x, double from, double to) {
  Ring a, b;
  for (const Vec2& p : profile) {
    a.push_back(along_x ? Vec3(from, p.x(), p.y()) : Vec3(p.x(), from, p.y()));
    b.push_back(along_x ? Vec3(to, p.x(), p.y()) : Vec3(p.x(), to, p.y()));
  }
  loft({a, b});
}

void Solids::swept_roof(const Outline& eaves, const Outline& ridge, double z, double rise,
                        double lift, double thickness) {
  constexpr int kPerSide = 6, kSteps = 5;
  const Sampled low = sample(eaves, kPerSide), high = sample(ridge, kPerSide);
  const auto ring = [&](double t, double dz) {
    Ring r;
    for (std::size_t i = 0; i < low.points.size(); ++i) {
      const Vec2 p = low.points[i] + t * (high.points[i] - low.points[i]);
      const double height = rise * (0.55 * t + 0.45 * t * t);
      const double corner = lift * std::pow(low.cornerness[i], 3) * (1 - t) * (1 - t);
      r.emplace_back(p.x(), p.y(), z + dz + height + corner);
    }
    return r;
  };
  std::vector<Ring> rings{ring(0, 0), ring(0, thickness)};
  for (int k = 1; k <= kSteps; ++k)
    rings.push_back(ring(static_cast<double>(k) / kSteps, thickness));
  loft(rings);
}

void Solids::gable_roof(double width, double length, double z, double rise, double overhang,
                        bool ridge_along_x, double thickness) {
  const double half = width / 2, drop = overhang * rise / half;
  const double from = -length / 2 - overhang, to = length / 2 + overhang;
  for (const double side : {-1.0, 1.0}) {
    const Outline slab{{0, z + rise},
                       {side * (half + overhang), z - drop},
                       {side * (half + overhang), z - drop + thickness},
                       {0, z + rise + thickness}};
    extrude(slab, ridge_along_x, from, to);
  }
  extrude({{-half, z}, {half, z}, {0, z + rise}}, ridge_along_x, -length / 2, length / 2);
}

void Solids::wall(double length, double thickness, double z0, double z1,
                  const std::vector<Eigen::Vector4d>& openings) {
  std::vector<double> cuts{-length / 2, length / 2};
  for (const auto& o : openings) cuts.insert(cuts.end(), {o[0], o[2]});
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double x0 = cuts[i], x1 = cuts[i + 1], mid = (x0 + x1) / 2;
    if (x1 - x0 < 1e-6) continue;
    std::vector<std::pair<double, double>> holes;
    for (const auto& o : openings) {
      if (o[0] < mid && mid < o[2]) holes.emplace_back(o[1], o[3]);
    }
    std::sort(holes.begin(), holes.end());
    double z = z0;
    for (const auto& [low, high] : holes) {
      if (low > z + 1e-6) box({x0, -thickness / 2, z}, {x1, thickness / 2, low});
      z = std::max(z, high);
    }
    if (z < z1 - 1e-6) box({x0, -thickness / 2, z}, {x1, thickness / 2, z1});
  }
}

void Solids::arch(double width, double depth, double height, double opening, double spring_z) {
  constexpr int kSteps = 8;
  const double r = opening / 2;
  box({-width / 2, -depth / 2, 0}, {-r, depth / 2, height});
  box({r, -depth / 2, 0}, {width / 2, depth / 2, height});
  for (int k = 0; k < kSteps; ++k) {
    const auto point = [&](int i) {
      const double a = std::numbers::pi * (1 - static_cast<double>(i) / kSteps);
      return Vec2(r * std::cos(a), spring_z + r * std::sin(a));
    };
    const Vec2 a = point(k), b = point(k + 1);
    extrude({a, b, {b.x(), height}, {a.x(), height}}, false, -depth / 2, depth / 2);
  }
}

}  // namespace muster::world
