#include <algorithm>
#include <cmath>

#include "common/nav/trajectory.h"

namespace muster::nav {
namespace {

constexpr double kMaxStep_s = 0.1;
constexpr double kHoverAfter_s = 2;  ///< the place of arrival must stay free this long
constexpr double kSlack_m = 1e-3;
constexpr double kOthersStep_m = 0.05;

/// Distance from `p` to the cube of voxel `k` with edge `edge_m`; the UGV's is measured in its
/// plane.
double cube_distance(const Vec3& p, map::VoxelKey k, double edge_m, bool in_plane) {
  const Vec3 low(k.x * edge_m, k.y * edge_m, k.z * edge_m);
  Vec3 d = (low - p).cwiseMax(p - low - Vec3::Constant(edge_m)).cwiseMax(Vec3::Zero());
  if (in_plane) d.z() = 0;
  return d.norm();
}

/// The body against the map. Keeps what does not change along a trajectory.
class MapGuard {
 public:
  MapGuard(const map::VoxelMap& map, double radius_m) : map_(map), radius_m_(radius_m) {
    const auto& config = map.config();
    edge_m_ = config.resolution_m;
    ground_ = config.ground;
    occupied_gap_m_ = guaranteed_gap(config.body_radius_m + config.clearance_m);
    unknown_m_ = std::min(radius_m, guaranteed_gap(config.body_radius_m));
    reach_ = static_cast<int>(std::ceil(radius_m / edge_m_));
    if (ground_) {
      // As for traversability: from above the ground itself to a little above the body.
      above_ = static_cast<int>(std::floor((radius_m + 0.1) / edge_m_));
      below_ = static_cast<int>(std::floor((config.ride_height_m - 0.2) / edge_m_ + 1e-9));
    }
  }

  /// How deep the body is in something occupied or unknown; 0: safe.
  double depth(const Vec3& p) {
    const map::VoxelKey key = map_.body_key(p);
    if (key != last_ || !asked_) {
      last_ = key;
      asked_ = true;
      open_ = occupied_gap_m_ >= radius_m_ && map_.traversable(key);
    }
    return open_ ? 0 : exact_depth(p, key);
  }

 private:
  /// A voxel that keeps `reach_m` from its centre to all cubes of a kind: how far any point *in* it
  /// is from them.
  double guaranteed_gap(double reach_m) const {
    const int n = static_cast<int>(std::ceil(reach_m / edge_m_)) + 2;
    const auto centre = [&](int d) { return d == 0 ? 0.0 : (d - 0.5) * edge_m_; };
    const auto side = [&](int d) { return d == 0 ? 0.0 : (d - 1) * edge_m_; };
    double least = n * edge_m_;
    for (int x = 0; x <= n; ++x) {
      for (int y = 0; y <= x; ++y) {
        for (int z = 0; z <= (ground_ ? 0 : y); ++z) {
          if (std::hypot(centre(x), centre(y), centre(z)) <= reach_m + 1e-9) continue;
          least = std::min(least, std::hypot(side(x), side(y), side(z)));
        }
      }
    }
    return least + 1e-9;
  }

  double exact_depth(const Vec3& p, map::VoxelKey c) const {
    double deepest = 0;
    const int low = ground_ ? -below_ : -reach_, high = ground_ ? above_ : reach_;
    for (int dz = low; dz <= high; ++dz) {
      for (int dy = -reach_; dy <= reach_; ++dy) {
        for (int dx = -reach_; dx <= reach_; ++dx) {
          const map::VoxelKey k{c.x + dx, c.y + dy, c.z + dz};
          const double gap = cube_distance(p, k, edge_m_, ground_);
          if (gap >= radius_m_) continue;
          const map::Voxel voxel = map_.at(k);
          if (voxel == map::Voxel::kFree) continue;
          // A UGV's lidar sees one plane: above and below it nothing is ever known free.
          if (voxel == map::Voxel::kUnknown && (gap >= unknown_m_ || (ground_ && dz != 0)))
            continue;
          const double limit = voxel == map::Voxel::kUnknown ? unknown_m_ : radius_m_;
          deepest = std::max(deepest, limit - gap);
        }
      }
    }
    return deepest > kSlack_m ? deepest : 0;
  }

  const map::VoxelMap& map_;
  double radius_m_, edge_m_ = 0.2, occupied_gap_m_ = 0, unknown_m_ = 0;
  bool ground_ = false, asked_ = false, open_ = false;
  int reach_ = 0, above_ = 0, below_ = 0;
  map::VoxelKey last_;
};

/// One other body.
class Other {
 public:
  Other(const Mover& mover, double required_m)
      : mover_(&mover), robot_(mover.robot), required_m_(required_m) {}
  Other(const map::Sphere& sphere, double required_m)
      : centre_(sphere.center), required_m_(required_m) {}

  /// Too near, and not merely still too near while getting away. `first`: where our body was at the
  /// start.
  bool conflict(SimTime t, const Vec3& p, const Vec3& first) {
    const Vec3 there = mover_ ? mover_->at(t) : centre_;
    const double distance = (p - there).norm();
    if (!started_) {
      started_ = true;
      escaping_ = distance < required_m_;
    }
    if (distance >= required_m_ - kSlack_m) {
      escaping_ = false;
      return false;
    }
    // Too near from the beginning: whatever leaves us no nearer than staying would is allowed, or
    // two robots would freeze for ever.
    return !escaping_ || distance < std::min((first - there).norm(), required_m_) - kSlack_m;
  }

  RobotId robot() const { return robot_; }
  std::string name() const {
    return robot_ == kNoRobot ? "obstacle" : "robot " + std::to_string(robot_.value);
  }

 private:
  const Mover* mover_ = nullptr;
  Vec3 centre_ = Vec3::Zero();
  RobotId robot_ = kNoRobot;
  double required_m_ = 0;
  bool started_ = false, escaping_ = false;
};

std::vector<Other> others_of(double radius_m, std::span<const Mover> movers,
                             std::span<const map::Sphere> obstacles, double margin_m) {
  std::vector<Other> others;
  for (const Mover& m : movers) {
    if (!m.announced.empty()) others.emplace_back(m, radius_m + m.radius_m + margin_m);
  }
  for (const auto& s : obstacles) others.emplace_back(s, radius_m + s.radius_m + margin_m);
  return others;
}

/// `depth(p)`: how deep the body at `p` is in what it must not be in.
template <class Depth>
std::optional<Unsafe> sweep(const Trajectory& trajectory, SimTime from, double step_m,
                            std::vector<Other> others, Depth&& depth_at) {
  if (trajectory.empty()) return std::nullopt;
  const Vec3 first = trajectory.at(from).p;
  double depth = depth_at(first);
  bool inside = depth > 0;
  const SimTime moving_until = std::max(from, trajectory.end());
  const SimTime last =
      others.empty() ? moving_until : moving_until + Duration::from_s(kHoverAfter_s);
  for (SimTime t = from;;) {
    const State s = trajectory.at(t);
    if (t <= moving_until) {
      const double now = depth_at(s.p);
      // In contact with the map already (drift, a late discovery): out is allowed, deeper is not.
      if (now > 0 && (!inside || now > depth + kSlack_m)) return Unsafe{t, s.p, "map", kNoRobot};
      inside = now > 0;
      depth = now;
    }
    for (Other& other : others) {
      if (other.conflict(t, s.p, first)) return Unsafe{t, s.p, other.name(), other.robot()};
    }
    if (t >= last) return std::nullopt;
    // The speed changes by little within a step; a quarter more covers it.
    const double fast = std::max(0.25, s.v_mps.norm() * 1.25);
    t = std::min(last, t + Duration::from_s(std::min(kMaxStep_s, step_m / fast)));
  }
}

}  // namespace

std::optional<Unsafe> check(const Trajectory& trajectory, SimTime from, const map::VoxelMap& map,
                            double radius_m, std::span<const Mover> movers,
                            std::span<const map::Sphere> obstacles, double margin_m) {
  const double step_m = std::max(0.02, map.config().clearance_m / 2);
  MapGuard guard(map, radius_m);
  return sweep(trajectory, from, step_m, others_of(radius_m, movers, obstacles, margin_m),
               [&](const Vec3& p) { return guard.depth(p); });
}

std::optional<Unsafe> check_others(const Trajectory& trajectory, SimTime from, double radius_m,
                                   std::span<const Mover> movers,
                                   std::span<const map::Sphere> obstacles, double margin_m) {
  return sweep(trajectory, from, kOthersStep_m, others_of(radius_m, movers, obstacles, margin_m),
               [](const Vec3&) { return 0.0; });
}

}  // namespace muster::nav
