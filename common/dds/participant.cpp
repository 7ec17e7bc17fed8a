#include "common/dds/participant.h"

#include <cstdlib>

#include "common/core/error.h"
#include "common/dds/network.h"
#include "common/dds/shuffle.h"
#include "common/dds/vendors.h"

namespace muster::dds {
namespace {

std::uint64_t shuffle_seed(const ParticipantConfig& config) {
  if (config.shuffle_seed != 0) return config.shuffle_seed;
  const char* text = std::getenv("MUSTER_DDS_SHUFFLE");
  return text == nullptr ? 0 : std::strtoull(text, nullptr, 10);
}

}  // namespace

Vendor vendor_from(const std::string& name) {
  if (name == "cyclonedds") return Vendor::kCyclone;
  if (name == "fastdds") return Vendor::kFast;
  throw BadInput("DDS vendor '" + name + "' is not one of cyclonedds, fastdds");
}

const char* to_string(Vendor vendor) {
  return vendor == Vendor::kCyclone ? "cyclonedds" : "fastdds";
}

Profile profile_from(const std::string& name) {
  if (name == "sim-localhost") return Profile::kSimLocalhost;
  if (name == "wired") return Profile::kWired;
  if (name == "wifi-unicast") return Profile::kWifiUnicast;
  throw BadInput("DDS profile '" + name + "' is not one of sim-localhost, wired, wifi-unicast");
}

std::unique_ptr<Participant> make_participant(const ParticipantConfig& config) {
  if (config.domain >= kDomains) {
    throw BadInput("DDS domain " + std::to_string(config.domain) + " is not below " +
                   std::to_string(kDomains));
  }
  std::unique_ptr<Participant> made = config.vendor == Vendor::kCyclone
                                          ? make_cyclone_participant(config)
                                          : make_fast_participant(config);
  if (const std::uint64_t seed = shuffle_seed(config); seed != 0) {
    made = shuffled(std::move(made), seed, RobotId{config.participant});
  }
  return made;
}

std::string up_partition(RobotId id) { return "up." + std::to_string(id.value); }
std::string down_partition(RobotId id) { return "down." + std::to_string(id.value); }
std::string bus_partition(RobotId id) { return "bus." + std::to_string(id.value); }

}  // namespace muster::dds
