#pragma once

#include <map>
#include <optional>

#include "common/robot/agreement.h"
#include "common/robot/strategy.h"
#include "gcs/strategy/regions.h"

namespace muster::gcs {

/// The station of SLEI3D (S0 IV-B4, IV-D): assigns boxes, drives to the agreed meetings in the
/// order of a tour with time windows, waits there no longer than the window, collects maps and
/// results, and declares the mission complete from its own records: every region done, every area
/// known inspected, with its image here. One that is started again without its journal hears an
/// explorer first, and then goes on from what that one knows.
class Slei3dStation : public robot::Strategy {
 public:
  Slei3dStation(const mission::Mission& mission, RobotId self);

  robot::Intent decide(robot::Knowledge& knowledge, const robot::Progress& progress) override;
  bool declares_complete() const override { return declared_; }

 private:
  bool begin(robot::Knowledge& knowledge);
  void meet(robot::Knowledge& knowledge);
  void count_missed(robot::Knowledge& knowledge);
  std::optional<RobotId> next_partner(robot::Knowledge& knowledge);
  Vec3 parking_for(robot::Knowledge& knowledge, const Vec3& place);
  void declare(robot::Knowledge& knowledge);

  Regions regions_;
  std::map<RobotId, robot::Agreement> agreements_;
  bool assigned_ = false;
  bool declared_ = false;
  SimTime tour_again_;
  std::optional<RobotId> partner_;
  std::optional<std::pair<Vec3, Vec3>> parking_;  // for which place, where
  SimTime parking_again_;
};

}  // namespace muster::gcs
