#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/core/random.h"
#include "commsim/world/reachable.h"
#include "commsim/world/scene.h"
#include "commsim/world/view.h"

namespace muster::world {
namespace {

constexpr double kAnyIncidence_rad = 80 * std::numbers::pi / 180;

struct Spot {
  Vec3 position, normal;
};

/// Area-uniform points on the surfaces where features may be.
class Sampler {
 public:
  Sampler(const Scene& scene, const mission::Mission& mission)
      : mesh_(scene.mesh()), mission_(mission) {
    double area = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Vec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
      if (!may_hold_features(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c))) continue;
      area += (b - a).cross(c - a).norm() / 2;
      triangles_.push_back(t);
      cumulative_m2_.push_back(area);
    }
  }
  bool empty() const { return cumulative_m2_.empty() || cumulative_m2_.back() <= 0; }

  /// A spot above the least height inside a box, with the first box's weight; nullopt when this
  /// draw fell elsewhere.
  std::optional<Spot> draw(Random& random) const {
    const double at = random.uniform(0, cumulative_m2_.back());
    const auto it = std::upper_bound(cumulative_m2_.begin(), cumulative_m2_.end(), at);
    const auto i = std::min<std::size_t>(static_cast<std::size_t>(it - cumulative_m2_.begin()),
                                         triangles_.size() - 1);
    const Vec3 a = corner(triangles_[i], 0), b = corner(triangles_[i], 1),
               c = corner(triangles_[i], 2);
    const double s = std::sqrt(random.uniform()), t = random.uniform();
    const double accepted = random.uniform();
    const Spot spot{(1 - s) * a + s * (1 - t) * b + s * t * c, (b - a).cross(c - a).normalized()};
    const double heaviest = std::max(1.0, mission_.features.first_box_weight);
    return accepted < weight(spot.position) / heaviest ? std::optional(spot) : std::nullopt;
  }

 private:
  Vec3 corner(std::size_t t, int i) const {
    return mesh_.vertices[static_cast<std::size_t>(mesh_.triangles[t][i])].cast<double>();
  }
  bool may_hold_features(const Vec3& low, const Vec3& high) const {
    if (high.z() <= mission_.features.min_height_m) return false;
    return std::any_of(mission_.boxes.begin(), mission_.boxes.end(), [&](const Box& box) {
      return (box.low().array() <= high.array()).all() && (box.high().array() >= low.array()).all();
    });
  }
  double weight(const Vec3& p) const {
    if (p.z() <= mission_.features.min_height_m) return 0;
    if (mission_.boxes.front().contains(p)) return mission_.features.first_box_weight;
    return std::any_of(mission_.boxes.begin(), mission_.boxes.end(),
                       [&](const Box& box) { return box.contains(p); })
               ? 1
               : 0;
  }

  const Mesh& mesh_;
  const mission::Mission& mission_;
  std::vector<std::size_t> triangles_;
  std::vector<double> cumulative_m2_;
};

/// Whether some explorer can sight a spot and some inspector can inspect it, both from where they
/// can get to.
class Judge {
 public:
  Judge(const Scene& scene, const mission::Mission& m, const ReachableSpace& reachable)
      : finder_(scene, reachable, m) {
    for (const auto& r : m.fleet) {
      if (r.vehicle.ground || r.vehicle.camera.range_m <= 0) continue;
      if (r.role == mission::Role::kInspector) {
        add(inspect_, ViewRule(r.vehicle, m.inspect.range_m, m.inspect.max_incidence_rad));
      } else if (r.role == mission::Role::kExplorer) {
        add(sight_, ViewRule(r.vehicle, m.sensing.sighting_range_m, kAnyIncidence_rad));
      }
    }
  }

  /// Where one solid of a recipe runs into another there is no surface.
  bool is_buried(const Spot& spot) const {
    return !finder_.is_outside(spot.position, spot.normal) &&
           !finder_.is_outside(spot.position, -spot.normal);
  }

  /// Turns the normal to the side that can be seen; a mesh's winding does not always tell.
  bool accept(Spot& spot) const {
    for (const Vec3& normal : {Vec3(spot.normal), Vec3(-spot.normal)}) {
      if (!finder_.is_outside(spot.position, normal)) continue;
      if (!any(spot.position, normal, inspect_) || !any(spot.position, normal, sight_)) continue;
      spot.normal = normal;
      return true;
    }
    return false;
  }

 private:
  static void add(std::vector<ViewRule>& rules, const ViewRule& rule) {
    const bool known = std::find(rules.begin(), rules.end(), rule) != rules.end();
    if (!known) rules.push_back(rule);
  }
  bool any(const Vec3& p, const Vec3& normal, const std::vector<ViewRule>& rules) const {
    return std::any_of(rules.begin(), rules.end(), [&](const ViewRule& rule) {
      return finder_.find(p, normal, rule).has_value();
    });
  }

  ViewFinder finder_;
  std::vector<ViewRule> inspect_, sight_;
};

}  // namespace

FeatureSet draw_features(const Scene& scene, const mission::Mission& mission,
                         const ReachableSpace& reachable) {
  constexpr std::uint64_t kDrawsPerFeature = 20'000;
  FeatureSet set;
  const std::uint32_t wanted = mission.features.count;
  if (wanted == 0) return set;
  const Sampler sampler(scene, mission);
  if (sampler.empty()) {
    throw BadInput(mission.file + ": boxes: no surface above " +
                   std::to_string(mission.features.min_height_m) + " m lies inside a box");
  }
  const Judge judge(scene, mission, reachable);
  Random random(mission.seed, kWorldId, "features"),
      traits(mission.seed, kWorldId, "feature traits");
  const auto next = [&](bool real) {
    for (std::uint64_t i = 0; i < kDrawsPerFeature; ++i) {
      std::optional<Spot> spot = sampler.draw(random);
      if (!spot || judge.is_buried(*spot)) continue;
      set.drawn += real;
      if (judge.accept(*spot)) return *spot;
      set.rejected += real;
    }
    throw BadInput(mission.file + ": features.count: only " + std::to_string(set.features.size()) +
                   " of " + std::to_string(wanted) + " features can be sighted and inspected");
  };
  const auto as_feature = [](std::size_t i, const Spot& spot) {
    Feature f;
    f.id = FeatureId{static_cast<std::uint32_t>(i)};
    f.position = spot.position;
    f.normal = spot.normal;
    return f;
  };
  for (std::size_t i = 0; i < wanted; ++i) {
    set.features.push_back(as_feature(i, next(true)));
    set.features.back().priority = traits.chance(mission.features.priority_share) ? 1 : 0;
  }
  const auto decoys = static_cast<std::size_t>(std::lround(wanted * mission.sensing.false_areas));
  for (std::size_t i = 0; i < decoys; ++i) {
    set.decoys.push_back(as_feature(i, next(false)));
    set.decoys.back().real = false;
  }
  return set;
}

FeatureSet draw_features(const Scene& scene, const mission::Mission& mission) {
  return draw_features(scene, mission, ReachableSpace(scene, mission));
}

}  // namespace muster::world
