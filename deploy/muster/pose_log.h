#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/mission/messages.h"
#include "common/mission/mission.h"

namespace muster::command {

/// Where robots were over time, to be replayed: what a motion capture recorded, or `tracks.csv` of
/// a run.
///
///     t_s,robot,x,y,z,yaw_rad
///     0.0,1,0.000,11.000,0.400,-1.571
///
/// Columns in any order, `yaw_rad` may be missing, others are passed over. Each robot's rows ascend
/// in time. Between two of them a robot is on the straight line, unless they are more than `kGap_s`
/// apart: then nobody knew where it was.
class PoseLog {
 public:
  static constexpr double kGap_s = 2;

  /// Throws BadInput with file and line.
  static PoseLog load(const std::string& file, const mission::Mission& mission);

  double begin_s() const { return begin_s_; }
  double end_s() const { return end_s_; }
  std::set<RobotId> robots() const;
  /// Those whose place is known then, by id.
  std::vector<mission::TrueState> at(double t_s) const;

 private:
  struct Row {
    double t_s;
    Pose pose;
  };
  std::map<RobotId, std::vector<Row>> tracks_;
  double begin_s_ = 0, end_s_ = 0;
};

}  // namespace muster::command
