#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// Ports and addresses, the same for both vendors: the formula of the RTPS specification with its
/// default parameters.
namespace muster::dds {

inline constexpr std::uint32_t kDomains =
    100;  ///< from here on, ports run into the ephemeral range
inline constexpr std::uint32_t kMeshOnLocalhost =
    64;  ///< participants that find each other without a hub
inline constexpr std::uint32_t kPerHost =
    4;  ///< participants of one domain on one machine in the field
inline constexpr const char* kLoopback = "127.0.0.1";

/// Where participant `index` of `domain` hears discovery (unicast). Its data port is one above.
constexpr std::uint16_t discovery_port(std::uint32_t domain, std::uint32_t index) {
  return static_cast<std::uint16_t>(7410 + 250 * domain + 2 * index);
}

/// Dotted address of an interface name, host name or dotted address. Throws Failure when there is
/// no such thing.
std::string resolve_interface(const std::string& name_or_address);
/// Waits until an interface (name or address) has a carrier: Fast DDS never opens a socket on one
/// that had none when it looked.
void await_carrier(const std::string& name_or_address);
std::string resolve_host(const std::string& name_or_address);

/// A place in a domain on this machine: discovery port and data port of one participant index. Held
/// by name in the kernel, so that it ends with the process and two that start in the same instant
/// cannot both have it.
class PortClaim {
 public:
  /// Throws Failure when another process has this index or its ports.
  PortClaim(std::uint32_t domain, std::uint32_t index);
  /// The first index below `count` that is free. Throws Failure naming the domain.
  static PortClaim first_free(std::uint32_t domain, std::uint32_t count);
  PortClaim(PortClaim&& other) noexcept;
  PortClaim& operator=(PortClaim&& other) noexcept;
  ~PortClaim();

  std::uint32_t index() const { return index_; }

 private:
  std::uint32_t index_;
  int fd_ = -1;
};

}  // namespace muster::dds
