#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <stdexcept>

namespace muster::test {

/// A DDS domain in 20 … 68 such that nobody holds a hub's ports of it or of the next one.
///
/// Tests run beside each other and beside other people's: a fixed domain would be taken now and
/// then. The search starts at a place given by the process, so that two that start together do not
/// take the same.
inline std::uint32_t free_domain() {
  constexpr std::uint32_t kFirst = 20, kPairs = 25;
  const auto is_free = [](std::uint32_t port) {
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const bool free = bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    close(fd);
    return free;
  };
  // RTPS 9.6.1.1: participant 0 of a domain listens at 7410 + 250·domain and one above.
  const auto pair_is_free = [&](std::uint32_t domain) {
    const std::uint32_t port = 7410 + 250 * domain;
    return is_free(port) && is_free(port + 1) && is_free(port + 250) && is_free(port + 251);
  };
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    const std::uint32_t domain = kFirst + 2 * ((static_cast<std::uint32_t>(getpid()) + i) % kPairs);
    if (pair_is_free(domain)) return domain;
  }
  throw std::runtime_error("no DDS domain between 20 and 69 is free");
}

}  // namespace muster::test
