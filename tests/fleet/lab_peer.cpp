// Robots of a lab, as small as they can be: the field's shell with nothing in it but beacons, and
// the drivers that it needs.
//   lab_peer drivers VENDOR DOMAIN ID…   their clocks, in one process
//   lab_peer robot VENDOR DOMAIN ID      says on stdout whose beacons it hears
#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "common/core/program.h"
#include "common/dds/convert.h"
#include "common/dds/field.h"

namespace {

using namespace muster;

volatile std::sig_atomic_t g_stop = 0;

struct Arguments {
  std::string what;
  dds::Vendor vendor{};
  std::uint32_t domain = 0;
  std::vector<RobotId> robots;
};

std::uint32_t number(const char* text) { return static_cast<std::uint32_t>(std::stoul(text)); }

int drive(const Arguments& arguments) {
  dds::ParticipantConfig config;
  config.vendor = arguments.vendor;
  config.domain = arguments.domain;
  const auto bus = dds::make_participant(config);
  std::vector<std::unique_ptr<dds::Writer>> writers;
  for (const RobotId robot : arguments.robots)
    writers.push_back(bus->writer(mission::MessageClass::kOdometry, dds::bus_partition(robot),
                                  dds::Delivery::kEvery));
  fmt::print("up\n");
  std::fflush(stdout);
  const auto start = std::chrono::steady_clock::now();
  mission::Odometry odometry;
  odometry.envelope.src = kWorldId;
  while (!g_stop) {
    ++odometry.envelope.n;
    const std::chrono::duration<double> now = std::chrono::steady_clock::now() - start;
    odometry.time = SimTime::from_s(now.count());
    const mission::Message message = dds::encode(odometry);
    for (const auto& writer : writers) writer->write(message.cdr);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return 0;
}

int listen(const Arguments& arguments) {
  dds::FieldConfig config;
  config.self = arguments.robots.front();
  config.vendor = arguments.vendor;
  config.bus_domain = arguments.domain;
  config.air_domain = arguments.domain + 1;
  config.air_profile = dds::Profile::kSimLocalhost;
  config.link = dds::Link::kRadio;
  dds::FieldRunner runner(config);
  mission::Beacon beacon;
  beacon.envelope.src = config.self;
  runner.run(
      [&](const mission::StepInput& input) {
        for (const mission::Message& m : input.air)
          fmt::print("heard {}\n", dds::peek_envelope(m.cdr).src.value);
        std::fflush(stdout);
        ++beacon.envelope.n;
        beacon.mission_time = input.now;
        mission::StepOutput output;
        output.air.push_back(dds::encode(beacon));
        return output;
      },
      g_stop);
  return 0;
}

}  // namespace

int main(int count, char** argument) {
  return run_program("lab_peer", [&] {
    if (count < 5) return kExitBadInput;
    for (int signal : {SIGTERM, SIGINT}) std::signal(signal, [](int) { g_stop = 1; });
    Arguments arguments{argument[1], dds::vendor_from(argument[2]), number(argument[3]), {}};
    for (int i = 4; i < count; ++i) arguments.robots.emplace_back(number(argument[i]));
    return arguments.what == "drivers" ? drive(arguments) : listen(arguments);
  });
}
