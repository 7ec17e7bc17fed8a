#include "deploy/muster/scene_render.h"

#include <png.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/core/error.h"

namespace muster::command {
namespace {

using Color = Eigen::Array3d;

const Color kSkyLow{0.93, 0.94, 0.96}, kSkyHigh{0.62, 0.74, 0.88};
const Color kGround{0.72, 0.70, 0.64}, kWall{0.86, 0.82, 0.74}, kRoof{0.62, 0.38, 0.30};

/// An orthographic camera: parallel rays keep a site readable at any size.
struct Camera {
  Vec3 target, right, up, forward;
  double half_width_m, half_height_m;
  double far_m;

  Vec3 origin(double u, double v) const {
    return target - far_m * forward + u * half_width_m * right + v * half_height_m * up;
  }
  /// u, v in −1 … 1 and the depth along the ray.
  Vec3 project(const Vec3& p) const {
    const Vec3 d = p - target;
    return {d.dot(right) / half_width_m, d.dot(up) / half_height_m, far_m + d.dot(forward)};
  }
};

Camera make_camera(const Vec3& low, const Vec3& high, const RenderOptions& o) {
  const double az = o.azimuth_deg * std::numbers::pi / 180;
  const double el = o.elevation_deg * std::numbers::pi / 180;
  Camera c;
  c.target = o.target.value_or((low + high) / 2);
  c.forward = -Vec3(std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), std::sin(el));
  c.right = c.forward.cross(Vec3::UnitZ()).normalized();
  c.up = c.right.cross(c.forward);
  c.far_m = 2 * (high - low).norm() + 50;
  double u = 0, v = 0;
  for (const Vec3& corner : Box::from_corners(low, high).corners()) {
    u = std::max(u, std::abs((corner - c.target).dot(c.right)));
    v = std::max(v, std::abs((corner - c.target).dot(c.up)));
  }
  const double aspect = static_cast<double>(o.width) / o.height;
  c.half_width_m = 1.05 * std::max(u, v * aspect) / o.zoom;
  c.half_height_m = c.half_width_m / aspect;
  return c;
}

class Picture {
 public:
  Picture(int width, int height)
      : width_(width),
        height_(height),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), Color::Zero()),
        depth_(pixels_.size(), 1e9) {}

  int width() const { return width_; }
  int height() const { return height_; }
  void set(int x, int y, const Color& color, double depth) {
    pixels_[at(x, y)] = color;
    depth_[at(x, y)] = depth;
  }
  /// Mixes a colour in; what lies behind a surface shows faintly.
  void mark(int x, int y, const Color& color, double depth) {
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
    const double share = depth < depth_[at(x, y)] + 0.05 ? 0.9 : 0.18;
    pixels_[at(x, y)] += share * (color - pixels_[at(x, y)]);
  }
  void save(const std::string& file) const;

 private:
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  int width_, height_;
  std::vector<Color> pixels_;
  std::vector<double> depth_;
};

void Picture::save(const std::string& file) const {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(pixels_.size() * 3);
  for (const Color& c : pixels_) {
    for (int i = 0; i < 3; ++i) {
      bytes.push_back(static_cast<std::uint8_t>(std::lround(255 * std::clamp(c[i], 0.0, 1.0))));
    }
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_);
  image.height = static_cast<png_uint_32>(height_);
  image.format = PNG_FORMAT_RGB;
  if (!png_image_write_to_file(&image, file.c_str(), 0, bytes.data(), 0, nullptr)) {
    throw Failure(file + ": cannot be written: " + image.message);
  }
}

/// Of a surface: by what it probably is (ground, roof, wall), by the sun, and by how open its
/// surroundings are.
Color shade(const world::Scene& scene, const Vec3& p, const Vec3& n) {
  static const Vec3 sun = Vec3(-0.45, -0.6, 0.9).normalized();
  const Color base = p.z() < 0.02 ? kGround : n.z() > 0.35 && n.z() < 0.9995 ? kRoof : kWall;
  const Vec3 from = p + 0.02 * n;
  const double direct = std::max(0.0, n.dot(sun));
  const bool lit = direct > 0 && !scene.cast(from, sun, 400);
  const Vec3 side = n.cross(std::abs(n.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX()).normalized();
  const Vec3 other = n.cross(side);
  // A different turn of the rays at every point: grain is kinder to the eye than stripes.
  const double grain =
      std::abs(std::remainder(127.1 * p.x() + 311.7 * p.y() + 74.7 * p.z(), 1.0)) * 2;
  int open = 0;
  constexpr int kRays = 12;
  for (int i = 0; i < kRays; ++i) {
    const double a = 2 * std::numbers::pi * (i + grain) / kRays;
    const Vec3 d = (0.6 * n + 0.8 * (std::cos(a) * side + std::sin(a) * other)).normalized();
    open += !scene.cast(from, d, 3);
  }
  const double ambient = (0.3 + 0.2 * n.z()) * (0.35 + 0.65 * open / kRays);
  return base * (ambient + 0.15 + (lit ? 0.65 * direct : 0.0));
}

void paint_scene(const world::Scene& scene, const Camera& camera, Picture& picture) {
  const double dx = 2.0 / picture.width(), dy = 2.0 / picture.height();
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      Color sum = Color::Zero();
      double nearest = 1e9;
      for (const auto& [sx, sy] : {std::pair{0.25, 0.25}, std::pair{0.75, 0.75}}) {
        const double u = (x + sx) * dx - 1, v = 1 - (y + sy) * dy;
        const Vec3 o = camera.origin(u, v);
        const auto hit = scene.cast(o, camera.forward, 4 * camera.far_m);
        if (hit) {
          sum += shade(scene, o + hit->distance_m * camera.forward, hit->normal);
          nearest = std::min(nearest, hit->distance_m);
        } else {
          sum += kSkyLow + (v + 1) / 2 * (kSkyHigh - kSkyLow);
        }
      }
      picture.set(x, y, sum / 2, nearest);
    }
  }
}

void draw_dot(const Camera& camera, Picture& picture, const Vec3& p, int radius,
              const Color& color) {
  const Vec3 q = camera.project(p);
  const int x = static_cast<int>((q.x() + 1) / 2 * picture.width());
  const int y = static_cast<int>((1 - q.y()) / 2 * picture.height());
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      if (dx * dx + dy * dy <= radius * radius) picture.mark(x + dx, y + dy, color, q.z() - 0.2);
    }
  }
}

void draw_line(const Camera& camera, Picture& picture, const Vec3& a, const Vec3& b,
               const Color& color) {
  const Vec3 pa = camera.project(a), pb = camera.project(b);
  const double across = std::max(std::abs(pb.x() - pa.x()) * picture.width(),
                                 std::abs(pb.y() - pa.y()) * picture.height());
  const int n = std::max(1, static_cast<int>(across / 2));
  for (int i = 0; i <= n; ++i) {
    const Vec3 q = pa + static_cast<double>(i) / n * (pb - pa);
    picture.mark(static_cast<int>((q.x() + 1) / 2 * picture.width()),
                 static_cast<int>((1 - q.y()) / 2 * picture.height()), color, q.z());
  }
}

void draw_box(const Camera& camera, Picture& picture, const Box& box, const Color& color) {
  const auto c = box.corners();
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t next = (i + 1) % 4;
    draw_line(camera, picture, c[i], c[next], color);
    draw_line(camera, picture, c[i + 4], c[next + 4], color);
    draw_line(camera, picture, c[i], c[i + 4], color);
  }
}

Color role_color(mission::Role role) {
  switch (role) {
    case mission::Role::kStation:
      return {0.9, 0.55, 0.0};
    case mission::Role::kExplorer:
      return {0.0, 0.55, 0.2};
    case mission::Role::kInspector:
      return {0.1, 0.2, 0.85};
  }
  return Color::Zero();
}

void draw_mission(const Camera& camera, Picture& picture, const mission::Mission& m,
                  const std::vector<world::Feature>& features) {
  for (std::size_t i = m.boxes.size(); i-- > 0;) {
    draw_box(camera, picture, m.boxes[i], i == 0 ? Color(0.75, 0.1, 0.5) : Color(0.1, 0.4, 0.7));
  }
  for (const auto& f : features) draw_dot(camera, picture, f.position, 2, {0.85, 0.05, 0.1});
  for (const auto& r : m.fleet) draw_dot(camera, picture, r.start.p, 4, role_color(r.role));
}

}  // namespace

void render(const world::Scene& scene, const mission::Mission* mission,
            const std::vector<world::Feature>& features, const std::string& file,
            const RenderOptions& options) {
  Vec3 low = scene.low(), high = scene.high();
  if (mission) {
    low = mission->hull.low();
    high = mission->hull.high();
  }
  high.z() = std::min(high.z(), scene.high().z());
  const Camera camera = make_camera(low, high, options);
  Picture picture(options.width, options.height);
  paint_scene(scene, camera, picture);
  if (mission) draw_mission(camera, picture, *mission, features);
  picture.save(file);
}

}  // namespace muster::command
