#include "deploy/muster/free_domain.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/core/error.h"

namespace muster::command {
namespace {

constexpr std::uint32_t kFirst = 70, kLast = 97;

/// The hub's unicast discovery port (RTPS 9.6.1.1, participant 0).
std::uint16_t hub_port(std::uint32_t domain) {
  return static_cast<std::uint16_t>(7400 + 250 * domain + 10);
}

bool port_is_free(std::uint16_t port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) throw Failure("cannot make a UDP socket");
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const bool free = bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(fd);
  return free;
}

/// A pair of domains that is in use by either of its ports is in use.
bool pair_is_free(std::uint32_t domain) {
  for (std::uint32_t d : {domain, domain + 1}) {
    for (std::uint16_t port : {hub_port(d), static_cast<std::uint16_t>(hub_port(d) + 1)}) {
      if (!port_is_free(port)) return false;
    }
  }
  return true;
}

}  // namespace

std::uint32_t free_domain(std::optional<std::uint32_t> wished) {
  if (wished) {
    if (*wished > 98)
      throw BadInput(
          fmt::format("--domain: {} is beyond 98 (the radio uses the one after it)", *wished));
    if (!pair_is_free(*wished)) {
      throw Failure(fmt::format("--domain: {} is in use: another run holds UDP port {} or {}",
                                *wished, hub_port(*wished), hub_port(*wished + 1)));
    }
    return *wished;
  }
  // Two runs started together must not both take the first.
  const std::uint32_t pairs = (kLast - kFirst + 1) / 2;
  const auto offset = static_cast<std::uint32_t>(getpid()) % pairs;
  for (std::uint32_t i = 0; i < pairs; ++i) {
    const std::uint32_t domain = kFirst + 2 * ((i + offset) % pairs);
    if (pair_is_free(domain)) return domain;
  }
  throw Failure(fmt::format(
      "no free DDS domain between {} and {}: end another run, or choose one with --domain", kFirst,
      kLast));
}

}  // namespace muster::command
