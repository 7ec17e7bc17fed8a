#pragma once

#include <csignal>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/core/time.h"
#include "common/dds/barrier.h"
#include "common/dds/inbox.h"
#include "common/dds/own_clock.h"
#include "common/mission/process.h"

namespace muster::dds {

/// Whom a robot on its own clock talks to.
enum class Link {
  kDirect,  ///< everybody, in partition `air`: the real radio decides who hears it
  kRadio,   ///< a lab's muster-commsim, in partitions `up.<id>` and `down.<id>`: that decides
};
/// "direct" | "radio". Throws BadInput.
Link link_from(const std::string& name);

struct FieldConfig {
  RobotId self;
  bool station = false;
  Vendor vendor = Vendor::kCyclone;
  std::uint32_t bus_domain = 0;  ///< drivers (or the simulated world), on this computer only
  std::uint32_t air_domain = 1;  ///< everybody
  Link link = Link::kDirect;
  Profile air_profile = Profile::kWifiUnicast;
  std::string network_interface;
  std::vector<std::string> peers;
  double speed = 1;  ///< mission seconds per second; other than 1 only with a simulated world
};

/// A robot on its own clock: no barrier, no hub on the air. Steps ten times a second with whatever
/// has arrived.
///
/// Mission time is MissionClock's, from odometry stamps and beacons. Before the first odometry
/// nothing happens: a robot that does not know where it is does not act.
class FieldRunner {
 public:
  using Step = std::function<mission::StepOutput(const mission::StepInput&)>;

  explicit FieldRunner(const FieldConfig& config);
  ~FieldRunner();

  /// Until `stop`, which may be set from a signal handler; looked at every step.
  void run(const Step& step, const volatile std::sig_atomic_t& stop);

 private:
  void sort_in(std::vector<mission::Message>&& messages);
  double now_s() const;

  FieldConfig config_;
  Inbox inbox_;
  std::unique_ptr<Participant> bus_, air_;
  ReaderSet samples_, air_in_reader_;
  WriterSet commands_, air_out_;
  std::vector<mission::Message> bus_in_, air_in_;
  OwnClock own_;
};

}  // namespace muster::dds
