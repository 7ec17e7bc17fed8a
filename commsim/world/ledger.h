#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "common/mission/messages.h"
#include "common/store/record.h"
#include "commsim/world/scene.h"

namespace muster::world {

/// What has become of every true feature: sighted, inspected, delivered; when and by whom.
///
/// A feature is delivered when the station holds the result that names it *and* every part of its
/// image, and the world did give that robot exactly this result: an id or an image it never gave is
/// refused and reported.
class FeatureLedger {
 public:
  static constexpr SimTime kEver{std::numeric_limits<std::int64_t>::max()};

  struct Entry {
    std::optional<SimTime> sighted, inspected, delivered;
    RobotId sighted_by = kNoRobot, inspected_by = kNoRobot, delivered_by = kNoRobot;
    SimTime delivered_look;  ///< when what was delivered had been inspected
  };
  struct AreaCounts {
    std::uint32_t real = 0, empty = 0, duplicate = 0;
  };
  struct Receipt {
    std::vector<FeatureId> delivered;  ///< for the first time
    std::string violation;             ///< why it was refused; empty: it was not
  };

  explicit FeatureLedger(const std::vector<Feature>& features);

  /// True when it is the first sighting.
  bool sighted(FeatureId id, RobotId by, SimTime now);
  /// What the world answered to an inspection (found or empty). Returns the features inspected for
  /// the first time.
  std::vector<FeatureId> answered(RobotId by, const mission::Inspected& answer, SimTime now);
  /// A record of class kInspection or kImage reached the station. Throws BadInput when its bytes
  /// are no inspection.
  Receipt received(const store::Record& record, SimTime now);

  /// What `robot` had inspected before `until` and what never reached the station of that: its work
  /// that was lost with it, or with its disk. `again`: who inspected the feature later, if anybody
  /// did.
  struct Redone {
    FeatureId feature;
    SimTime inspected;
    std::optional<SimTime> again;
    RobotId again_by = kNoRobot;
  };
  std::vector<Redone> lost_with(RobotId robot, SimTime until = kEver) const;

  /// The station holds nothing any more: nothing is delivered until it is delivered anew.
  void station_lost_all();

  const Entry& entry(std::size_t feature) const { return entries_[feature]; }
  std::size_t total() const { return entries_.size(); }
  std::uint32_t count_sighted() const { return sighted_; }
  std::uint32_t count_inspected() const { return inspected_; }
  std::uint32_t count_delivered() const { return delivered_; }
  const AreaCounts& areas() const { return areas_; }
  /// When `count` of the features had been delivered.
  std::optional<SimTime> delivered_time(std::uint32_t count) const;

  std::string csv(const std::vector<Feature>& features) const;

 private:
  struct Given {
    SimTime at;
    std::vector<FeatureId> features;
    std::uint64_t payload_hash = 0;
  };
  /// One inspection on its way: robot, area, instant.
  using ResultKey = std::tuple<RobotId, mission::AreaRef, SimTime>;
  struct Arrival {
    std::vector<FeatureId> features;
    bool has_result = false, settled = false;
    std::uint32_t parts = 1;
    std::map<std::uint32_t, Bytes> payload;
  };
  const Given* given_to(RobotId by, const std::vector<FeatureId>& ids,
                        std::optional<std::uint64_t> payload_hash) const;
  Receipt settle(RobotId by, Arrival& arrival, SimTime now);

  std::vector<Entry> entries_;
  std::map<RobotId, std::vector<Given>> given_;
  std::map<ResultKey, Arrival> arrivals_;
  std::vector<SimTime> deliveries_;
  std::uint32_t sighted_ = 0, inspected_ = 0, delivered_ = 0;
  AreaCounts areas_;
};

}  // namespace muster::world
