#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "common/core/ids.h"
#include "commsim/world/scene.h"

namespace muster::world {

/// A body as the referee of contacts sees it.
struct MovingBody {
  RobotId id;
  Vec3 p = Vec3::Zero();
  double radius_m = 0;
  bool resting = false;             ///< stands on the ground: its footing is no collision
  bool flying = false;              ///< counts for min_clearance_m
  std::optional<double> footing_z;  ///< UGV: contacts below this height are what it drives over
};

struct Contact {
  RobotId robot;
  RobotId other = kNoRobot;  ///< kNoRobot: the site
  Vec3 p = Vec3::Zero();
};

/// Finds contacts of bodies with the site (FCL, sphere against the mesh) and with each other. A
/// contact counts once, until the two have been 5 cm apart. FCL is asked only when the clearance
/// known from an earlier place, less the way since, no longer excludes a touch.
class CollisionChecker {
 public:
  explicit CollisionChecker(const Scene& scene);
  ~CollisionChecker();

  /// The bodies after one sub-step, always in the same order. Returns the contacts that began.
  std::vector<Contact> step(const std::vector<MovingBody>& bodies);

  /// Smallest gap between two bodies so far, surface to surface; nullopt with fewer than two.
  std::optional<double> min_separation_m() const { return min_separation_; }
  /// Smallest gap between a flying body and the site so far; nullopt when it never was below
  /// `kCareM`.
  std::optional<double> min_clearance_m() const { return min_clearance_; }

  /// Gaps above this are not measured.
  static constexpr double kCareM = 3;

 private:
  struct Site;
  struct Known {
    Vec3 p = Vec3::Zero();
    double clearance_m = -1;  ///< at p, at most the cap; < 0: never asked
  };
  bool touches_site(std::size_t i, const MovingBody& body);
  double clearance(std::size_t i, const MovingBody& body, double needed_m);

  const Scene& scene_;
  std::unique_ptr<Site> site_;
  std::vector<Known> known_;
  std::vector<char> on_site_;
  std::vector<char> on_pair_;
  std::optional<double> min_separation_, min_clearance_;
};

}  // namespace muster::world
