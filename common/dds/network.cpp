#include "common/dds/network.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstring>
#include <memory>
#include <thread>
#include <utility>

#include "common/core/error.h"
#include "common/core/log.h"

namespace muster::dds {
namespace {

std::string dotted(const sockaddr* address) {
  sockaddr_in in{};
  std::memcpy(&in, address, sizeof in);
  char text[INET_ADDRSTRLEN] = {};
  inet_ntop(AF_INET, &in.sin_addr, text, sizeof text);
  return text;
}

bool udp_port_free(std::uint16_t port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) throw Failure("no UDP socket: " + std::string(std::strerror(errno)));
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_port = htons(port);
  // Without SO_REUSEADDR this fails even if the other one shares its port.
  const bool free = bind(fd, reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0;
  close(fd);
  return free;
}

}  // namespace

namespace {

struct Interface {
  std::string name, address;
  bool running = false;
};

Interface find_interface(const std::string& name_or_address) {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) throw Failure("the network interfaces cannot be listed");
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, freeifaddrs);
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET) continue;
    const std::string address = dotted(i->ifa_addr);
    if (name_or_address == i->ifa_name || name_or_address == address)
      return {i->ifa_name, address, (i->ifa_flags & IFF_RUNNING) != 0};
  }
  throw Failure("network interface '" + name_or_address +
                "' does not exist or has no IPv4 address (`ip -4 address` lists them)");
}

}  // namespace

std::string resolve_interface(const std::string& name_or_address) {
  return find_interface(name_or_address).address;
}

void await_carrier(const std::string& name_or_address) {
  bool said = false;
  while (true) {
    const Interface interface = find_interface(name_or_address);
    if (interface.running) return;
    if (!std::exchange(said, true)) log::warn("waiting for a carrier on {}", interface.name);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

std::string resolve_host(const std::string& name_or_address) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(name_or_address.c_str(), nullptr, &hints, &found) != 0) {
    throw Failure("peer '" + name_or_address + "' is neither an address nor a known host");
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, freeaddrinfo);
  return dotted(found->ai_addr);
}

PortClaim::PortClaim(std::uint32_t domain, std::uint32_t index) : index_(index) {
  fd_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  // After a 0 byte: a name, not a file.
  const std::string text = "muster-dds-" + std::to_string(domain) + "-" + std::to_string(index);
  std::memcpy(name.sun_path + 1, text.data(), text.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  const bool claimed = fd_ >= 0 && bind(fd_, reinterpret_cast<const sockaddr*>(&name), size) == 0;
  const std::uint16_t port = discovery_port(domain, index);
  if (claimed && udp_port_free(port) && udp_port_free(static_cast<std::uint16_t>(port + 1))) return;
  if (fd_ >= 0) close(fd_);
  throw Failure("DDS domain " + std::to_string(domain) + " is in use on this machine (UDP port " +
                std::to_string(port) + "); choose another domain");
}

PortClaim PortClaim::first_free(std::uint32_t domain, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    try {
      return PortClaim(domain, i);
    } catch (const Failure&) {
      // taken: the next one
    }
  }
  throw Failure("DDS domain " + std::to_string(domain) + ": all " + std::to_string(count) +
                " places on this machine are taken");
}

PortClaim::PortClaim(PortClaim&& other) noexcept
    : index_(other.index_), fd_(std::exchange(other.fd_, -1)) {}

PortClaim& PortClaim::operator=(PortClaim&& other) noexcept {
  std::swap(index_, other.index_);
  std::swap(fd_, other.fd_);
  return *this;
}

PortClaim::~PortClaim() {
  if (fd_ >= 0) close(fd_);
}

}  // namespace muster::dds
