#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <map>
#include <string>

#include "deploy/muster/doctor.h"

namespace muster::command {
namespace {

using Verdict = Check::Verdict;

constexpr const char* kTopic = "Network";
constexpr std::uint32_t kDomains = 100;  ///< above, ports run into the ephemeral range
/// Fast DDS asks for this much; a scan burst of fifty robots needs it.
constexpr long kWantedBuffer_bytes = 4'194'304;

struct Interface {
  std::string addresses;
  unsigned flags = 0;
};

std::map<std::string, Interface> interfaces() {
  std::map<std::string, Interface> all;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return all;
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    Interface& one = all[entry->ifa_name];
    one.flags = entry->ifa_flags;
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address{};
    std::memcpy(&address, entry->ifa_addr, sizeof address);
    char text[INET_ADDRSTRLEN] = "";
    inet_ntop(AF_INET, &address.sin_addr, text, sizeof text);
    one.addresses += (one.addresses.empty() ? "" : ", ") + std::string(text);
  }
  freeifaddrs(list);
  return all;
}

/// Bound and closed again at once: says whether somebody else has it.
bool udp_port_free(std::uint16_t port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  address.sin_port = htons(port);
  sockaddr generic{};
  static_assert(sizeof generic == sizeof address);
  std::memcpy(&generic, &address, sizeof address);
  const bool free = bind(fd, &generic, sizeof generic) == 0;
  close(fd);
  return free;
}

long number_in(const std::string& path) {
  long value = -1;
  std::ifstream(path) >> value;
  return value;
}

}  // namespace

Checks check_interfaces() {
  Checks checks;
  bool outside = false, loopback = false;
  for (const auto& [name, one] : interfaces()) {
    const bool up = (one.flags & IFF_UP) && (one.flags & IFF_RUNNING),
               local = one.flags & IFF_LOOPBACK;
    std::string text = name + ": " + (one.addresses.empty() ? "no IPv4 address" : one.addresses) +
                       (up ? "" : ", down");
    if (!local) text += (one.flags & IFF_MULTICAST) ? ", multicast" : ", no multicast";
    checks.push_back(
        {kTopic, text, up && !one.addresses.empty() ? Verdict::kGood : Verdict::kNote, ""});
    if (up && !one.addresses.empty()) (local ? loopback : outside) = true;
  }
  if (!loopback)
    checks.push_back({kTopic, "no loopback interface is up: processes on this computer cannot meet",
                      Verdict::kBad, "ip link set lo up"});
  if (!outside)
    checks.push_back(
        {kTopic, "no interface leads off this computer: simulation only", Verdict::kNote, ""});
  return checks;
}

std::vector<std::uint32_t> taken_domains() {
  std::vector<std::uint32_t> taken;
  for (std::uint32_t d = 0; d < kDomains; ++d) {
    // The first participant's discovery port: a hub must have exactly this one.
    if (!udp_port_free(static_cast<std::uint16_t>(7410 + 250 * d))) taken.push_back(d);
  }
  return taken;
}

Checks check_ports() {
  const std::vector<std::uint32_t> taken = taken_domains();
  if (taken.empty())
    return {{kTopic, "all DDS domains 0 to 99 are free (UDP ports 7410 + 250·domain)",
             Verdict::kGood, ""}};
  std::string list;
  for (const std::uint32_t d : taken) list += (list.empty() ? "" : ", ") + std::to_string(d);
  const std::string found = "DDS domains in use on this computer: " + list;
  if (taken.size() + 1 < kDomains) return {{kTopic, found, Verdict::kNote, ""}};
  return {{kTopic, found, Verdict::kBad,
           "nothing is free for a run; `ss -ulpn` names who has the ports"}};
}

Checks check_buffers() {
  Checks checks;
  for (const std::string which : {"rmem_max", "wmem_max"}) {
    const long bytes = number_in("/proc/sys/net/core/" + which);
    const std::string found = "net.core." + which + " is " +
                              (bytes < 0 ? "unknown" : std::to_string(bytes / 1024) + " kB");
    if (bytes >= kWantedBuffer_bytes || bytes < 0) {
      checks.push_back({kTopic, found, bytes < 0 ? Verdict::kNote : Verdict::kGood, ""});
    } else {
      checks.push_back(
          {kTopic,
           found + ": bursts of large messages are sent again, or lost where nothing is reliable",
           Verdict::kWarn,
           "sysctl -w net.core." + which + "=" + std::to_string(kWantedBuffer_bytes)});
    }
  }
  return checks;
}

}  // namespace muster::command
