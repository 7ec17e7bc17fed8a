#include "common/dds/barrier.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <utility>

namespace muster::dds {

BarrierConfig BarrierConfig::from(Vendor vendor, std::uint32_t domain) {
  BarrierConfig config;
  config.vendor = vendor;
  config.domain = domain;
  if (const char* patience = std::getenv("MUSTER_PATIENCE")) {
    const double factor = std::max(1.0, std::strtod(patience, nullptr));
    config.start *= factor;
    config.missing *= factor;
    config.busy *= factor;
    config.silence *= factor;
  }
  return config;
}

namespace {

constexpr std::uint32_t kSeats = 60;

std::uint32_t seat(RobotId robot) {
  if (robot.value >= kSeats) {
    throw BadInput("robot " + std::to_string(robot.value) + ": over DDS robot ids go up to " +
                   std::to_string(kSeats - 1));
  }
  return robot.value + 1;
}

}  // namespace

std::uint32_t participant_on_bus(RobotId robot) { return seat(robot); }
std::uint32_t participant_on_air(RobotId robot) { return kSeats + seat(robot); }

ParticipantConfig participant_config(const BarrierConfig& config, std::uint32_t domain,
                                     std::uint32_t participant) {
  ParticipantConfig all;
  all.vendor = config.vendor;
  all.profile = Profile::kSimLocalhost;
  all.domain = domain;
  all.participant = participant;
  all.star = true;
  return all;
}

namespace {

std::string of_life(const std::string& partition, Life life) {
  return life == kFirstLife ? partition : partition + "." + std::to_string(life);
}

}  // namespace

std::string bus_partition(RobotId robot, Life life) { return of_life(bus_partition(robot), life); }
std::string down_partition(RobotId robot, Life life) {
  return of_life(down_partition(robot), life);
}

mission::Done ready(const Lives& lives) {
  mission::Done done;
  done.k = kReady;
  for (const auto& [robot, life] : lives)
    done.deliveries.push_back({.process = robot, .bus = life, .air = life});
  return done;
}

Lives lives_in(const mission::Done& ready) {
  Lives lives;
  for (const mission::Expect& e : ready.deliveries) lives[e.process] = e.air;
  return lives;
}

bool said_of(const Lives& said, RobotId robot, const Lives& now) {
  const auto life = said.find(robot);
  return life != said.end() && life->second == now.at(robot);
}

void WriterSet::add(Participant& participant, mission::MessageClass cls,
                    const std::string& partition, const OnMatch& on_match, Delivery delivery) {
  writers_.push_back({cls, participant.writer(cls, partition, delivery, on_match)});
}

void WriterSet::write(const mission::Message& message) const {
  for (const Entry& entry : writers_) {
    if (entry.cls == message.cls) return entry.writer->write(message.cdr);
  }
  throw std::logic_error(std::string("a message of class ") + mission::topic_name(message.cls) +
                         " has no way out here");
}

bool WriterSet::matched(int readers) const {
  return std::all_of(writers_.begin(), writers_.end(),
                     [&](const Entry& e) { return e.writer->matched() >= readers; });
}

void Undertaker::bury(WriterSet&& writers) {
  std::erase_if(going_, [](const auto& writer) {
    return writer.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  });
  for (WriterSet::Entry& entry : writers.writers_) {
    going_.push_back(std::async(std::launch::async,
                                [writer = std::move(entry.writer)]() mutable { writer.reset(); }));
  }
  writers.writers_.clear();
}

void ReaderSet::add(Participant& participant, mission::MessageClass cls,
                    const std::string& partition, const OnMessage& on_message,
                    const OnMatch& on_match, Delivery delivery) {
  readers_.push_back(participant.reader(cls, partition, delivery, on_message, on_match));
}

bool ReaderSet::matched(int writers) const {
  return std::all_of(readers_.begin(), readers_.end(),
                     [&](const auto& r) { return r->matched() >= writers; });
}

}  // namespace muster::dds
