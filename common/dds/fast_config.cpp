#include "common/dds/fast_config.h"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>

#include <fastdds/dds/log/Log.hpp>
#include <mutex>

#include "common/core/log.h"
#include "common/dds/network.h"
#include "common/dds/vendors.h"

#ifdef __SANITIZE_ADDRESS__
// Fast DDS 2.9.1 deletes its statistics through a base class (88 bytes as 56) with every writer:
// its fault, not ours to report.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "new_delete_type_mismatch=0"; }
#endif

namespace muster::dds {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::Duration_t;

constexpr std::uint32_t kSocketBuffer = 4 << 20;
const Duration_t kMission{3600, 0};

class LogConsumer final : public fast::LogConsumer {
 public:
  void Consume(const fast::Log::Entry& entry) override { log::debug("fastdds: {}", entry.message); }
};

rtps::Locator_t locator(const std::string& address, std::uint32_t port) {
  rtps::Locator_t l;
  l.kind = LOCATOR_KIND_UDPv4;
  rtps::IPLocator::setIPv4(l, address);
  l.port = port;
  return l;
}

/// Where this participant is heard; empty: on all interfaces.
std::string own_address(const ParticipantConfig& c) {
  if (!c.network_interface.empty()) return resolve_interface(c.network_interface);
  return c.profile == Profile::kSimLocalhost ? kLoopback : "";
}

void add_peers(const ParticipantConfig& c, rtps::LocatorList_t& list) {
  const auto add_host = [&](const std::string& address, std::uint32_t places) {
    for (std::uint32_t i = 0; i < places; ++i) {
      list.push_back(locator(address, discovery_port(c.domain, i)));
    }
  };
  if (c.profile != Profile::kSimLocalhost) {
    for (const std::string& p : c.peers) add_host(resolve_host(p), kPerHost);
  } else {
    add_host(kLoopback, c.star ? 1 : kMeshOnLocalhost);
  }
}

template <class Qos>
void set_common(Qos& qos, bool reliable, int depth) {
  qos.reliability().kind =
      reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  // 0: no limit. The defaults lose the 11th instance without an error.
  qos.resource_limits().max_samples = 0;
  qos.resource_limits().max_instances = 0;
  qos.resource_limits().max_samples_per_instance = 0;
  qos.resource_limits().allocated_samples = 0;
  qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  qos.data_sharing().off();  // killed processes leave it behind
}

}  // namespace

void prepare_fast_library() {
  static std::once_flag once;
  std::call_once(once, [] {
    eprosima::fastrtps::LibrarySettingsAttributes settings;
    settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
    eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
    fast::Log::ClearConsumers();
    fast::Log::RegisterConsumer(std::make_unique<LogConsumer>());
  });
}

fast::DomainParticipantQos fast_participant_qos(const ParticipantConfig& config,
                                                std::uint32_t index) {
  fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
  const std::string address = own_address(config);

  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  if (!address.empty()) udp->interfaceWhiteList = {address};
  udp->sendBufferSize = udp->receiveBufferSize = kSocketBuffer;
  udp->maxMessageSize = longest_message(config.profile);
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);

  fast::WireProtocolConfigQos& wire = qos.wire_protocol();
  wire.participant_id = static_cast<std::int32_t>(index);
  const std::uint16_t port = discovery_port(config.domain, index);
  const std::string heard_at = address.empty() ? "0.0.0.0" : address;
  // Naming unicast locators turns multicast off.
  wire.builtin.metatrafficUnicastLocatorList.push_back(locator(heard_at, port));
  wire.default_unicast_locator_list.push_back(locator(heard_at, port + 1u));
  add_peers(config, wire.builtin.initialPeersList);

  auto& discovery = wire.builtin.discovery_config;
  // Liveliness decides nothing: who is gone is known from the launcher, or from beacons.
  discovery.leaseDuration = kMission;
  discovery.leaseDuration_announcementperiod = Duration_t{1, 0};
  discovery.initial_announcements.count = 20;
  discovery.initial_announcements.period = Duration_t{0, 100'000'000};
  wire.builtin.use_WriterLivelinessProtocol = false;
  return qos;
}

fast::DataWriterQos fast_writer_qos(bool reliable, int depth) {
  fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
  set_common(qos, reliable, depth);
  qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
  // Nothing blocks a writer but locks of its own process (keep-last). Where the machine is busy, a
  // thread that holds one may not run for long: not a reason to refuse a message, nor to skip the
  // heartbeat that would have it repeated, which Fast does silently when this time is over.
  qos.reliability().max_blocking_time = reliable ? kMission : Duration_t{0, 100'000'000};
  // Asking for an acknowledgement with every sample halves the rate of the barrier; loss on
  // loopback is rare, so ask now and then.
  qos.reliable_writer_qos().disable_heartbeat_piggyback = true;
  qos.reliable_writer_qos().times.heartbeatPeriod = Duration_t{0, 50'000'000};
  // The first heartbeat, still empty, goes out at once (fast_greeter.h: why that is not enough).
  qos.reliable_writer_qos().times.initialHeartbeatDelay = Duration_t{0, 0};
  qos.reliable_writer_qos().times.nackResponseDelay = Duration_t{0, 0};
  qos.reliable_writer_qos().times.nackSupressionDuration = Duration_t{0, 0};
  return qos;
}

fast::DataReaderQos fast_reader_qos(bool reliable, int depth) {
  fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
  set_common(qos, reliable, depth);
  qos.reliable_reader_qos().times.heartbeatResponseDelay = Duration_t{0, 0};
  return qos;
}

}  // namespace muster::dds
