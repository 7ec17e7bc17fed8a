// One real robot on its own clock, with drivers that say that it stands still: the field's shell,
// for the tests in network namespaces. Says on stdout what it hears on the air: monotonic time,
// topic, sender.
// SIGUSR1: the operator asks everyone to hold.
//   field_peer MISSION ID VENDOR PROFILE DOMAIN ADDRESS PEER X START
// START: the monotonic time at which mission time is 0.
#include <fmt/format.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <thread>

#include "agent/agent.h"
#include "common/core/program.h"
#include "common/dds/convert.h"
#include "common/dds/field.h"
#include "gcs/station.h"

namespace {

using namespace muster;
using Clock = std::chrono::steady_clock;

volatile std::sig_atomic_t g_stop = 0, g_asked = 0;
pid_t g_drivers = -1;

double monotonic_s() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// The drivers of a robot that stands at (x, 0, 1), in a process of their own as on a vehicle.
/// Their clock is the computer's, which namespaces share.
[[noreturn]] void drive(const dds::FieldConfig& robot, double x, double start_s) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  dds::ParticipantConfig config;
  config.vendor = robot.vendor;
  config.domain = robot.bus_domain;
  const auto bus = dds::make_participant(config);
  const auto writer = bus->writer(mission::MessageClass::kOdometry, dds::bus_partition(robot.self),
                                  dds::Delivery::kEvery);
  mission::Odometry odometry;
  odometry.envelope.src = kWorldId;
  odometry.pose.p = Vec3(x, 0, 1);
  const auto request = bus->writer(mission::MessageClass::kOperatorRequest,
                                   dds::bus_partition(robot.self), dds::Delivery::kEvery);
  std::signal(SIGUSR1, [](int) { g_asked = 1; });
  while (true) {
    if (g_asked) {
      g_asked = 0;
      mission::OperatorRequest hold;
      hold.envelope.src = kWorldId;
      hold.envelope.n = ++odometry.envelope.n;
      hold.verb = mission::RequestVerb::kHold;
      hold.robot = kNoRobot;
      request->write(dds::encode(hold).cdr);
    }
    ++odometry.envelope.n;
    odometry.time = SimTime::from_s(monotonic_s() - start_s);
    writer->write(dds::encode(odometry).cdr);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

int run(char** argument) {
  const mission::Mission mission = mission::Mission::load(argument[1], {});
  dds::FieldConfig config;
  config.self = RobotId{static_cast<std::uint32_t>(std::stoul(argument[2]))};
  config.vendor = dds::vendor_from(argument[3]);
  config.air_profile = dds::profile_from(argument[4]);
  config.air_domain = static_cast<std::uint32_t>(std::stoul(argument[5]));
  config.bus_domain = config.air_domain + 1;
  config.network_interface = argument[6];
  config.peers = {argument[7]};
  config.station = config.self == mission.station();
  g_drivers = fork();
  if (g_drivers == 0) drive(config, std::stod(argument[8]), std::stod(argument[9]));

  const auto robot = config.station ? gcs::make_station(mission, config.self, 1)
                                    : agent::make_agent(mission, config.self, 1);
  std::signal(SIGUSR1, [](int) { kill(g_drivers, SIGUSR1); });
  std::signal(SIGTERM, [](int) { g_stop = 1; });
  dds::FieldRunner runner(config);
  runner.run(
      [&](const mission::StepInput& input) {
        for (const mission::Message& m : input.air) {
          fmt::print("heard {:.3f} {} {}\n", monotonic_s(), mission::topic_name(m.cls),
                     dds::peek_envelope(m.cdr).src.value);
        }
        std::fflush(stdout);
        return robot->step(input);
      },
      g_stop);
  return 0;
}

}  // namespace

int main(int count, char** argument) {
  return run_program("field_peer", [&] { return count == 10 ? run(argument) : 2; });
}
