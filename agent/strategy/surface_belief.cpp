#include "agent/strategy/surface_belief.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace muster::agent {
namespace {

constexpr int kDirections = 320;
constexpr double kReach_m = 0.75;   // of the map around the area that tells how the surface lies
constexpr double kSlab_m = 0.13;    // half a voxel and a little
constexpr double kInFront = 0.5;    // what lies in front of a slab speaks against it, so much
constexpr double kSharpness = 14;   // of the map's say
constexpr int kFewVoxels = 5;       // below this the map says nothing
constexpr double kSoft_rad = 0.05;  // of the incidence limit
constexpr double kUsualRange_m = 2.5;
constexpr double kMapLies = 0.1;      // at edges and corners voxels say little: when what they say
                                      // has been refused, everything else is still to be believed
constexpr double kNegligible = 1e-5;  // against the likeliest direction
constexpr double kBelieved = 0.5;     // of a refusal: what the map is too coarse for, and bodies in
                                      // the way, refuse looks as well
constexpr double kLeastSigma_m = 0.05;
constexpr double kImpossible = 1e-4;  // of what contradicts an answer: the map may be wrong

/// A Fibonacci lattice: evenly spread, the same on every robot.
const std::vector<Vec3>& directions() {
  static const std::vector<Vec3> all = [] {
    std::vector<Vec3> d;
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    for (int i = 0; i < kDirections; ++i) {
      const double z = 1 - (2 * i + 1.0) / kDirections;
      const double r = std::sqrt(1 - z * z);
      d.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
    }
    return d;
  }();
  return all;
}

double step(double x, double width) { return 1 / (1 + std::exp(-x / width)); }

std::vector<Vec3> occupied_around(const map::VoxelMap& map, const Vec3& p) {
  std::vector<Vec3> found;
  const int reach = static_cast<int>(std::ceil(kReach_m / map.config().resolution_m));
  const map::VoxelKey k = map.key(p);
  for (int z = -reach; z <= reach; ++z) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const map::VoxelKey v{k.x + x, k.y + y, k.z + z};
        const Vec3 d = map.center(v) - p;
        if (d.norm() <= kReach_m && map.at(v) == map::Voxel::kOccupied) found.push_back(d);
      }
    }
  }
  return found;
}

/// How well the voxels lie in a slab square to `n` near the area, with little in front of it: at
/// most 1.
double slab(const std::vector<Vec3>& voxels, const Vec3& n) {
  double best = -1;
  for (const double offset : {-0.2, -0.1, 0.0, 0.1, 0.2}) {
    double score = 0, all = 0;
    for (const Vec3& d : voxels) {
      const double weight = 1 / (0.3 + d.norm());
      const double h = n.dot(d) - offset;
      score += weight * (h > kSlab_m ? -kInFront : h < -kSlab_m ? 0.0 : 1.0);
      all += weight;
    }
    best = std::max(best, score / all);
  }
  return best;
}

}  // namespace

SurfaceBelief::SurfaceBelief(const map::VoxelMap& map, const mission::Area& area,
                             const mission::InspectConfig& rule, const mission::Vehicle& vehicle)
    : rule_(rule),
      vehicle_(vehicle),
      sigma_m_(std::max(kLeastSigma_m, static_cast<double>(area.sigma_m))),
      weights_(kDirections, 1.0) {
  tabulate();
  const Vec3 last = (area.sighted_from.p - area.position).normalized();
  const Vec3 mean = area.normal.norm() > 0.5 ? area.normal : last;
  const std::vector<Vec3> voxels = occupied_around(map, area.position);
  const bool mapped = static_cast<int>(voxels.size()) >= kFewVoxels;
  std::vector<double> slabs(kDirections, 0.0);
  double best = -1;
  for (int i = 0; i < kDirections; ++i) {
    const Vec3& n = directions()[i];
    weights_[i] = step(n.dot(last), 0.04) * step(n.dot(mean), 0.04);
    if (!mapped || weights_[i] < 0.05) continue;
    slabs[i] = slab(voxels, n);
    best = std::max(best, slabs[i]);
  }
  if (mapped) {
    normalise();
    const std::vector<double> by_sight = weights_;
    for (int i = 0; i < kDirections; ++i) weights_[i] *= std::exp(kSharpness * (slabs[i] - best));
    normalise();
    for (int i = 0; i < kDirections; ++i)
      weights_[i] = kMapLies * by_sight[i] + (1 - kMapLies) * weights_[i];
  }
  normalise();
}

void SurfaceBelief::normalise() {
  const double most = *std::max_element(weights_.begin(), weights_.end());
  for (double& w : weights_) w = w < kNegligible * most ? 0 : w;
  const double sum = std::accumulate(weights_.begin(), weights_.end(), 0.0);
  for (double& w : weights_) w /= sum;
}

double SurfaceBelief::in_view(const Vec3& from, double range_m) const {
  const double elevation = std::asin(std::clamp(from.z(), -1.0, 1.0));
  const double spread_rad = std::max(0.01, sigma_m_ * std::cos(elevation) / range_m);
  const double margin_rad = vehicle_.camera.vfov_rad / 2 - std::abs(elevation + vehicle_.pitch_rad);
  const double reach_m = std::min(rule_.range_m, vehicle_.camera.range_m) - range_m;
  return step(margin_rad, 0.6 * spread_rad) * step(reach_m, 0.6 * sigma_m_);
}

void SurfaceBelief::tabulate() {
  for (std::size_t i = 0; i < square_.size(); ++i) {
    const double cosine = 2 * (static_cast<double>(i) + 0.5) / square_.size() - 1;
    square_[i] = step(rule_.max_incidence_rad - std::acos(cosine),
                      kSoft_rad + 0.5 * sigma_m_ / kUsualRange_m);
  }
}

double SurfaceBelief::square_enough(const Vec3& n, const Vec3& from) const {
  const double at = (n.dot(from) + 1) / 2 * square_.size();
  return square_[static_cast<std::size_t>(std::clamp(at, 0.0, square_.size() - 1.0))];
}

void SurfaceBelief::refuse(const RefusedLook& look) {
  const double seen = in_view(look.from, look.range_m);
  for (int i = 0; i < kDirections; ++i)
    weights_[i] *= 1 - kBelieved * look.clear * seen * square_enough(directions()[i], look.from);
  normalise();
}

void SurfaceBelief::accept(const Vec3& from) {
  for (int i = 0; i < kDirections; ++i)
    weights_[i] *= std::max(kImpossible, square_enough(directions()[i], from));
  normalise();
}

double SurfaceBelief::shows(const Vec3& from) const {
  double p = 0;
  for (int i = 0; i < kDirections; ++i) p += weights_[i] * step(directions()[i].dot(from), 0.04);
  return p;
}

double SurfaceBelief::faces(const Vec3& from) const {
  double p = 0;
  for (int i = 0; i < kDirections; ++i) {
    if (weights_[i] > 0) p += weights_[i] * square_enough(directions()[i], from);
  }
  return p;
}

Vec3 SurfaceBelief::normal() const {
  Vec3 n = Vec3::Zero();
  for (int i = 0; i < kDirections; ++i) n += weights_[i] * directions()[i];
  return n.norm() > 1e-6 ? Vec3(n.normalized()) : Vec3::UnitZ();
}

}  // namespace muster::agent
