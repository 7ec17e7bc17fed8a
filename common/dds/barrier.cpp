#include "common/dds/barrier.h"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <thread>

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

mission::Done ready() {
  mission::Done done;
  done.k = kReady;
  return done;
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

void WriterSet::abandon() {
  std::vector<std::jthread> going;
  for (Entry& entry : writers_) going.emplace_back([&entry] { entry.writer.reset(); });
  going.clear();
  writers_.clear();
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
