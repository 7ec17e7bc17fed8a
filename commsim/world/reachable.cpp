#include "commsim/world/reachable.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "commsim/world/triangle.h"

namespace muster::world {

ReachableSpace::ReachableSpace(const Scene& scene, const mission::Mission& mission) {
  double radius_m = 0;
  for (const auto& r : mission.fleet) {
    if (!r.vehicle.ground) radius_m = std::max(radius_m, r.vehicle.radius_m);
  }
  margin_m_ = radius_m + mission.clearance_m + kExtra_m;
  low_ = mission.hull.low();
  cells_ = ((mission.hull.high() - low_) / kCell_m).array().ceil().cast<int>();
  state_.assign(index({0, 0, cells_.z()}), State::kFree);
  block_outside(mission.hull, radius_m);
  const Mesh& mesh = scene.mesh();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto corner = [&](int i) -> Vec3 {
      return mesh.vertices[static_cast<std::size_t>(t[i])].cast<double>();
    };
    block_around(corner(0), corner(1), corner(2));
  }
  for (const auto& r : mission.fleet) {
    if (!r.vehicle.ground) flood(r.start.p);
  }
}

void ReachableSpace::block_outside(const Box& hull, double margin_m) {
  for (int z = 0; z < cells_.z(); ++z) {
    for (int y = 0; y < cells_.y(); ++y) {
      for (int x = 0; x < cells_.x(); ++x) {
        // The rim stays blocked, so that the flood needs no bounds check.
        const bool rim = x == 0 || y == 0 || z == 0 || x + 1 == cells_.x() || y + 1 == cells_.y() ||
                         z + 1 == cells_.z();
        if (rim || (hull.yaw_rad != 0 && !hull.contains(center({x, y, z}), -margin_m))) {
          state_[index({x, y, z})] = State::kBlocked;
        }
      }
    }
  }
}

void ReachableSpace::block_around(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 grow = Vec3::Constant(margin_m_ - 0.5 * kCell_m);
  const Eigen::Vector3i first =
      ((a.cwiseMin(b).cwiseMin(c) - grow - low_) / kCell_m).array().floor().max(0).cast<int>();
  const Eigen::Vector3i last = ((a.cwiseMax(b).cwiseMax(c) + grow - low_) / kCell_m)
                                   .array()
                                   .ceil()
                                   .cast<int>()
                                   .min(cells_.array() - 1);
  const Vec3 normal = (b - a).cross(c - a).normalized();  // zero for a degenerate one: no shortcut
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        State& s = state_[index({x, y, z})];
        if (s == State::kBlocked) continue;
        const Vec3 p = center({x, y, z});
        if (std::abs(normal.dot(p - a)) >= margin_m_) continue;
        const double d2 = (closest_on_triangle(p, a, b, c) - p).squaredNorm();
        if (d2 < margin_m_ * margin_m_) s = State::kBlocked;
      }
    }
  }
}

void ReachableSpace::flood(const Vec3& start) {
  const Eigen::Vector3i at = ((start - low_) / kCell_m).array().floor().cast<int>();
  std::vector<std::size_t> open;
  const auto visit = [&](std::size_t i) {
    if (state_[i] != State::kFree) return;
    state_[i] = State::kReached;
    open.push_back(i);
  };
  for (int z = -1; z <= 1; ++z) {  // the start lies between cells
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const Eigen::Vector3i i = at + Eigen::Vector3i(x, y, z);
        if ((i.array() >= 0).all() && (i.array() < cells_.array()).all()) visit(index(i));
      }
    }
  }
  const std::size_t row = index({0, 1, 0}), layer = index({0, 0, 1});
  while (!open.empty()) {
    const std::size_t i = open.back();
    open.pop_back();
    for (const std::size_t step : {std::size_t{1}, row, layer}) {
      visit(i + step);
      visit(i - step);
    }
  }
}

double ReachableSpace::volume_m3() const {
  const auto n = std::count(state_.begin(), state_.end(), State::kReached);
  return static_cast<double>(n) * kCell_m * kCell_m * kCell_m;
}

}  // namespace muster::world
