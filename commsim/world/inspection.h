#pragma once

#include <cstdint>
#include <vector>

#include "common/core/time.h"
#include "common/mission/messages.h"
#include "common/mission/mission.h"
#include "commsim/world/surroundings.h"

namespace muster::world {

/// One robot's inspection camera and what it is busy with (RULES "Sighting and inspecting").
///
///     request ──▶ watching: each 0.1 s, is the area in view? each true feature within match_m of it?
///                   ├─ a feature held hold_s without a break, no other under way   ─▶ kFound, ids
///                   ├─ no true feature near, area held hold_s                      ─▶ kEmpty
///                   ├─ nothing in view for hold_s + 3 s                            ─▶ kRefusedView
///                   └─ request 0 or (unless `inspect: shared`) a new request       ─▶ kCancelled
///
/// In view: within the camera's field of view and range, unoccluded by site and bodies, incidence
/// within the limit, the vehicle no faster than the limit. For a feature this is exact. The area
/// itself is a noisy estimate that may lie before or behind the surface, so what its ray meets
/// within match_m of it counts as its surface.
class InspectionCamera {
 public:
  InspectionCamera(const mission::RobotConfig& robot, const mission::Mission& mission,
                   const std::vector<Feature>& features);

  struct Answer {
    mission::Inspected message;  ///< all but envelope; payload filled when found
    Vec3 area = Vec3::Zero();
  };

  /// Returns what was cancelled by it.
  std::vector<Answer> request(const mission::Inspect& inspect, SimTime now);
  /// The process died: forget everything.
  void drop();
  /// Looks at instant `now`; `speed_mps` is the vehicle's fastest in the tick before. Returns
  /// finished actions.
  std::vector<Answer> look(const Surroundings& around, const Pose& pose, double speed_mps,
                           SimTime now);
  /// Working: an action that had its target in view at the last look.
  bool holding() const;
  bool busy() const { return !actions_.empty(); }

 private:
  /// Since when something has been in view without a break; `held` false: it is not in view.
  struct Hold {
    bool held = false;
    SimTime since;
  };
  struct Action {
    mission::Inspect inspect;
    SimTime last_in_view;  ///< or the request's instant
    Hold area;
    std::vector<std::size_t> candidates;  ///< true features within match_m
    std::vector<Hold> holds;              ///< one per candidate
  };

  bool in_reach(const Pose& pose, const Vec3& p) const;
  bool sees_feature(const Surroundings& around, const Pose& pose, const Feature& f) const;
  bool sees_area(const Surroundings& around, const Pose& pose, const Vec3& area) const;
  bool steep(const Vec3& from, const Vec3& p, const Vec3& normal) const;
  Answer answer(const Action& action, mission::InspectOutcome outcome, SimTime now) const;
  Answer found(const Action& action, SimTime now) const;

  RobotId id_;
  mission::Vehicle vehicle_;
  mission::InspectConfig config_;
  std::uint64_t seed_;
  const std::vector<Feature>& features_;
  std::vector<Action> actions_;
};

/// The image of an inspection: bytes that do not compress, the same for the same mission seed,
/// robot and area.
Bytes inspection_payload(std::uint64_t mission_seed, RobotId robot, const Vec3& area,
                         std::uint32_t size);

}  // namespace muster::world
