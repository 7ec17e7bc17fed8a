#include "common/dds/own_clock.h"

#include <catch2/catch.hpp>

#include "common/dds/convert.h"

using namespace muster;
using namespace muster::dds;

namespace {

constexpr RobotId kSelf{2}, kOther{3};

SimTime s(double t) { return SimTime::from_s(t); }

mission::Message odometry(double t_s) {
  mission::Odometry o;
  o.time = s(t_s);
  return encode(o);
}

mission::Message beacon(RobotId src, std::uint32_t stratum, double t_s) {
  mission::Beacon b;
  b.envelope.src = src;
  b.stratum = stratum;
  b.mission_time = s(t_s);
  b.trajectory.push_back({s(t_s + 2), {}});
  return encode(b);
}

/// Answers each step with a trajectory of one state in 10 s and a beacon, and keeps what it got.
class Echo : public mission::Process {
 public:
  explicit Echo(std::vector<mission::StepInput>& got) : got_(got) {}
  RobotId id() const override { return kSelf; }
  void finish(const std::string&) override {}
  mission::StepOutput step(const mission::StepInput& input) override {
    got_.push_back(input);
    mission::Trajectory t;
    mission::TimedState& state = t.states.emplace_back();
    state.t = input.now + Duration::from_s(10);
    mission::StepOutput output;
    output.bus.push_back(encode(t));
    output.air.push_back(beacon(kSelf, 0, input.now.s()));
    return output;
  }

 private:
  std::vector<mission::StepInput>& got_;
};

mission::Mission mission_with(std::vector<mission::ScriptedEvent> script) {
  mission::Mission m;
  for (const RobotId id : {kSelf, kOther}) {
    mission::RobotConfig robot;
    robot.id = id;
    robot.role = mission::Role::kExplorer;
    m.fleet.push_back(robot);
  }
  m.script = std::move(script);
  return m;
}

mission::ScriptedEvent skew(double at_s, RobotId robot, double by_s) {
  mission::ScriptedEvent e{s(at_s), "skew", robot};
  e.value = by_s;
  return e;
}

}  // namespace

TEST_CASE("a robot off by a minute sees and steers its drivers as if it were not") {
  std::vector<mission::StepInput> got;
  const auto process =
      with_own_clock(std::make_unique<Echo>(got), mission_with({skew(5, kSelf, 60)}));
  process->step({.tick = 49, .now = s(4.9), .bus = {odometry(4.9)}, .air = {}});
  const auto output = process->step({.tick = 50, .now = s(5), .bus = {odometry(5)}, .air = {}});
  CHECK(got[0].now == s(4.9));
  CHECK(got[1].now == s(65));
  CHECK(decode<mission::Odometry>(got[1].bus[0]).time == s(65));
  CHECK(decode<mission::Trajectory>(output.bus[0]).states[0].t == s(15));
  CHECK(decode<mission::Beacon>(output.air[0]).stratum == MissionClock::kUnknownStratum);
}

TEST_CASE("a skewed robot believes the first who follows the station, and says so") {
  std::vector<mission::StepInput> got;
  const auto process =
      with_own_clock(std::make_unique<Echo>(got), mission_with({skew(5, kSelf, -60)}));
  process->step({.tick = 50, .now = s(5), .bus = {}, .air = {}});
  const auto output =
      process->step({.tick = 100, .now = s(10), .bus = {}, .air = {beacon(kOther, 1, 9.9)}});
  CHECK(got[1].now == s(9.9));
  CHECK(decode<mission::Beacon>(output.air[0]).stratum == 2);
}

TEST_CASE("where a teammate with another idea of time will be is known all the same") {
  std::vector<mission::StepInput> got;
  const auto process =
      with_own_clock(std::make_unique<Echo>(got), mission_with({skew(5, kOther, 60)}));
  process->step({.tick = 60,
                 .now = s(6),
                 .bus = {},
                 .air = {beacon(kOther, MissionClock::kUnknownStratum, 66)}});
  const auto heard = decode<mission::Beacon>(got[0].air[0]);
  CHECK(heard.mission_time == s(6));
  CHECK(heard.trajectory[0].t == s(8));
}

TEST_CASE("where no clock is skewed nothing comes between a robot and the world's time") {
  std::vector<mission::StepInput> got;
  auto echo = std::make_unique<Echo>(got);
  const mission::Process* const bare = echo.get();
  CHECK(with_own_clock(std::move(echo), mission_with({})).get() == bare);
}

TEST_CASE("what happened to a clock before its process was started has not happened to it") {
  std::vector<mission::StepInput> got;
  const auto process =
      with_own_clock(std::make_unique<Echo>(got), mission_with({skew(5, kSelf, 60)}));
  process->step({.tick = 80, .now = s(8), .bus = {}, .air = {}});
  CHECK(got[0].now == s(8));
}
