#include "common/dds/cyclone_domain.h"

#include <map>
#include <mutex>
#include <optional>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/network.h"
#include "common/dds/vendors.h"

namespace muster::dds {
namespace {

struct Shared {
  dds_entity_t entity = 0;
  int users = 0;
  std::optional<PortClaim> ports;
};

std::mutex& registry_mutex() {
  static std::mutex mutex;
  return mutex;
}
std::map<std::uint32_t, Shared>& registry() {
  static std::map<std::uint32_t, Shared> domains;
  return domains;
}

std::string element(const std::string& name, const std::string& value) {
  return "<" + name + ">" + value + "</" + name + ">";
}

std::string general(const ParticipantConfig& c) {
  const bool sim = c.profile == Profile::kSimLocalhost;
  std::string interface = "<NetworkInterface autodetermine=\"true\" multicast=\"false\"/>";
  if (sim || !c.network_interface.empty()) {
    const std::string address =
        c.network_interface.empty() ? kLoopback : resolve_interface(c.network_interface);
    interface = "<NetworkInterface address=\"" + address + "\" multicast=\"false\"/>";
  }
  const std::uint32_t longest = longest_message(c.profile);
  return element("General", element("Interfaces", interface) + element("AllowMulticast", "false") +
                                element("MaxMessageSize", std::to_string(longest) + "B") +
                                element("FragmentSize", std::to_string(longest - 200) + "B"));
}

std::string peer(const std::string& address) { return "<Peer address=\"" + address + "\"/>"; }

std::string discovery(const ParticipantConfig& c, const std::optional<PortClaim>& ports) {
  std::string peers;
  std::uint32_t per_host = kPerHost;  // a peer without a port is tried at so many
  if (c.profile != Profile::kSimLocalhost) {
    for (const std::string& p : c.peers) peers += peer(resolve_host(p));
  } else if (c.star) {
    peers = peer(std::string(kLoopback) + ":" + std::to_string(discovery_port(c.domain, 0)));
  } else {
    per_host = kMeshOnLocalhost;
    peers = peer(kLoopback);
  }
  // Liveliness decides nothing: who is gone is known from the launcher, or from beacons.
  return element("Discovery",
                 element("ParticipantIndex", ports ? std::to_string(ports->index()) : "none") +
                     element("MaxAutoParticipantIndex", std::to_string(per_host - 1)) +
                     element("Peers", peers) + element("SPDPInterval", "1s") +
                     element("LeaseDuration", "3600s"));
}

// A packet lost on loopback (a full socket buffer) costs a nack delay: keep that short. Writers
// must never wait for a reader that is slow or dead, so the history's high-water mark is out of
// reach.
std::string internal() {
  return element("Internal", "<SocketReceiveBufferSize max=\"4MB\"/>" +
                                 element("NackDelay", "2ms") +
                                 "<HeartbeatInterval min=\"2ms\" minsched=\"10ms\" max=\"1s\">20ms"
                                 "</HeartbeatInterval>" +
                                 element("Watermarks", element("WhcHigh", "1GB")));
}

thread_local std::string last_error;

void log_line(void*, const dds_log_data_t* data) {
  std::string text(data->message, data->size);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  // Also about every peer that went away; that is for those who look.
  log::debug("cyclonedds: {}", text);
  if (data->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) last_error = text;
}

dds_entity_t create(const ParticipantConfig& config, const std::optional<PortClaim>& ports) {
  dds_set_log_sink(log_line, nullptr);
  const std::string xml = "<CycloneDDS><Domain id=\"any\">" + general(config) +
                          discovery(config, ports) + internal() + "</Domain></CycloneDDS>";
  const dds_entity_t entity = dds_create_domain(config.domain, xml.c_str());
  if (entity < 0) {
    throw Failure("DDS domain " + std::to_string(config.domain) + ": Cyclone DDS cannot open it: " +
                  (last_error.empty() ? dds_strretcode(entity) : last_error));
  }
  return entity;
}

}  // namespace

CycloneDomain::CycloneDomain(const ParticipantConfig& config) : id_(config.domain) {
  const std::lock_guard lock(registry_mutex());
  const auto found = registry().find(id_);
  if (found != registry().end()) {
    if (is_hub(config)) {
      throw Failure("DDS domain " + std::to_string(id_) +
                    " is already open in this process; its hub must come first");
    }
    ++found->second.users;
    return;
  }
  Shared shared;
  shared.ports = claim_ports(config);
  shared.entity = create(config, shared.ports);
  shared.users = 1;
  registry().emplace(id_, std::move(shared));
}

CycloneDomain::~CycloneDomain() {
  const std::lock_guard lock(registry_mutex());
  const auto found = registry().find(id_);
  if (--found->second.users > 0) return;
  dds_delete(found->second.entity);
  registry().erase(found);
}

}  // namespace muster::dds
