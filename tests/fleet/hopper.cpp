#include "tests/fleet/hopper.h"

#include <fstream>

#include "common/dds/convert.h"

namespace muster::test {
namespace {

using namespace mission;

class Hopper : public Process {
 public:
  Hopper(const Mission& mission, RobotId id, std::uint64_t epoch)
      : config_(mission.robot(id)), epoch_(epoch), pose_(config_.start) {}

  RobotId id() const override { return config_.id; }

  StepOutput step(const StepInput& input) override {
    now_ = input.now;
    StepOutput out;
    for (const Message& m : input.bus) read(m);
    for (const Message& m : input.air) heard_.add_bytes(m.cdr);
    if (input.tick % 5 == id().value % 5) out.air.push_back(beacon());
    if (input.tick % 40 == id().value % 40) out.air.push_back(area());
    if (input.tick % 30 == 0 && config_.role != Role::kStation)
      out.bus.push_back(hop(input.tick / 30 % 2 == 0));
    out.trace = heard_.value();
    out.activity = Activity::kExploring;
    return out;
  }

  void finish(const std::string& dir) override {
    if (config_.role == Role::kStation)
      std::ofstream(dir + "/station.db") << heard_.value() << '\n';
  }

 private:
  Envelope envelope() { return {.n = ++n_, .src = id(), .cls = {}, .sent = now_}; }

  void read(const Message& m) {
    heard_.add_bytes(m.cdr);
    if (m.cls == MessageClass::kOdometry) pose_ = dds::decode<Odometry>(m).pose;
  }

  Message beacon() {
    Beacon b;
    b.envelope = envelope();
    b.epoch = epoch_;
    b.mission_time = now_;
    b.pose = pose_;
    b.role = config_.role;
    return dds::encode(b);
  }

  Message area() {
    Area a;
    a.position = pose_.p;
    store::RecordHeader header;
    header.author = {id(), epoch_};
    header.cls = store::RecordClass::kArea;
    header.key = header.seq = ++areas_;
    header.stamp = now_;
    Envelope e = envelope();
    e.cls = MessageClass::kArea;
    return dds::wrap(e, dds::encode_record(header, a));
  }

  Message hop(bool up) {
    Trajectory t;
    t.envelope = envelope();
    t.id = n_;
    const Vec3 goal = config_.start.p + Vec3(0, 0, up ? 1.0 : 0.0);
    t.states = {{.t = now_, .p = pose_.p, .v_mps = Vec3::Zero(), .yaw_rad = pose_.yaw_rad},
                {.t = now_ + Duration::from_s(2.5),
                 .p = goal,
                 .v_mps = Vec3::Zero(),
                 .yaw_rad = pose_.yaw_rad}};
    return dds::encode(t);
  }

  const RobotConfig config_;
  const std::uint64_t epoch_;
  Pose pose_;
  SimTime now_;
  std::uint64_t n_ = 0, areas_ = 0;
  Hasher heard_;
};

}  // namespace

std::unique_ptr<Process> make_hopper(const Mission& mission, RobotId id, std::uint64_t epoch) {
  return std::make_unique<Hopper>(mission, id, epoch);
}

}  // namespace muster::test
