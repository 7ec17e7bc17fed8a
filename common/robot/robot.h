#pragma once

#include <memory>

#include "common/mission/process.h"
#include "common/radio/pace.h"
#include "common/robot/executive.h"
#include "common/robot/guardian.h"
#include "common/robot/knowledge.h"
#include "common/robot/map_sharer.h"
#include "common/robot/strategy.h"
#include "common/robot/whole_map.h"

namespace muster::robot {

/// One robot or station as a pure function of what reaches it. Once per tick:
///
///     bus, air ─▶ Knowledge ─▶ Strategy.decide ─▶ (Guardian may overrule) ─▶ Executive ─▶ bus
///                     │                                                          │
///                     └─ records, exchange ─▶ air ◀─ beacon, announced trajectory ┘
class Robot : public mission::Process {
 public:
  Robot(const mission::Mission& mission, RobotId self, std::unique_ptr<Strategy> strategy,
        std::uint64_t epoch);
  ~Robot() override;

  RobotId id() const override { return knowledge_.self(); }
  mission::StepOutput step(const mission::StepInput& input) override;
  void keep(std::unique_ptr<store::Journal> journal) override;
  mission::WholeMapBytes whole_map_bytes() override;
  void finish(const std::string& dir) override;

  const Knowledge& knowledge() const { return knowledge_; }
  const Intent& intent() const { return intent_; }
  const Executive& executive() const { return executive_; }

 private:
  void find_itself(const mission::Odometry& odometry);
  void take_bus(const mission::StepInput& input);
  void take_air(const mission::StepInput& input);
  void take_scan(const mission::Scan& scan);
  void take_request(const mission::OperatorRequest& request);
  void send_bus(Executive::Commands commands, mission::StepOutput& output);
  void send_air(mission::StepOutput& output);
  void send_record(std::uint64_t n, const store::Record& record, mission::StepOutput& output);
  void commit();
  mission::Beacon beacon();
  mission::Envelope envelope(mission::MessageClass cls);

  Knowledge knowledge_;
  std::unique_ptr<Strategy> strategy_;
  Guardian guardian_;
  Executive executive_;
  MapSharer map_sharer_;
  WholeMap whole_map_;
  radio::Pace pace_;
  std::unique_ptr<store::Journal> journal_;
  bool located_ = false;           // odometry was heard
  Bytes body_;                     // of a record that is on its way from the journal to the radio
  std::uint64_t kept_blocks_ = 0;  // cursor of the own map's changes
  std::size_t kept_looks_ = 0;
  SimTime keep_blocks_;
  Intent intent_;
  std::uint64_t sent_n_ = 0;
  SimTime beacon_due_;
  bool announce_ = false;
  std::uint32_t stratum_;
  std::vector<mission::PlanningTime> planning_;
};

}  // namespace muster::robot
