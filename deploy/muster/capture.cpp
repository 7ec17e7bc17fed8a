#include "deploy/muster/capture.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <span>
#include <vector>

#include "common/core/error.h"

namespace muster::command {
namespace {

constexpr std::uint32_t kSnap = 262'144;
constexpr std::size_t kIpAt = 14, kUdpHeader = 8;
constexpr int kBuffer = 64 << 20;

/// UDP over IPv4 whose payload begins with "RTPS".
constexpr sock_filter kRtps[] = {
    BPF_STMT(BPF_LD | BPF_H | BPF_ABS, 12),
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ETH_P_IP, 0, 6),
    BPF_STMT(BPF_LD | BPF_B | BPF_ABS, kIpAt + 9),
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, IPPROTO_UDP, 0, 4),
    BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, kIpAt),
    BPF_STMT(BPF_LD | BPF_W | BPF_IND, kIpAt + kUdpHeader),
    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 0x52545053, 0, 1),
    BPF_STMT(BPF_RET | BPF_K, kSnap),
    BPF_STMT(BPF_RET | BPF_K, 0),
};

[[noreturn]] void refused(const std::string& what) {
  const std::string why = std::strerror(errno);
  if (errno != EPERM && errno != EACCES) throw Failure("--capture: " + what + ": " + why);
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  throw Failure(fmt::format("--capture: {}: {}; this helps: sudo setcap cap_net_raw+ep {}", what,
                            why, self.string()));
}

int open_loopback() {
  const int fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) refused("packets may not be listened to");
  const sock_fprog filter{std::size(kRtps), const_cast<sock_filter*>(kRtps)};
  setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter);
  // Beyond the system's limit if we may, else up to it.
  if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &kBuffer, sizeof kBuffer) != 0)
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &kBuffer, sizeof kBuffer);
  const int on = 1;
  setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  sockaddr_ll loopback{};
  loopback.sll_family = AF_PACKET;
  loopback.sll_protocol = htons(ETH_P_ALL);
  loopback.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
  if (bind(fd, reinterpret_cast<const sockaddr*>(&loopback), sizeof loopback) != 0) {
    close(fd);
    refused("the loopback interface cannot be listened to");
  }
  return fd;
}

/// A pcapng block: type, length, body padded to 4, length again.
void write_block(std::ostream& out, std::uint32_t type, std::span<const std::uint32_t> words,
                 std::span<const std::uint8_t> bytes = {}) {
  const auto put = [&](std::uint32_t word) {
    out.write(reinterpret_cast<const char*>(&word), sizeof word);
  };
  const std::size_t padding = (4 - bytes.size() % 4) % 4;
  const auto length = static_cast<std::uint32_t>(12 + words.size_bytes() + bytes.size() + padding);
  put(type);
  put(length);
  for (const std::uint32_t word : words) put(word);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  for (std::size_t i = 0; i < padding; ++i) out.put(0);
  put(length);
}

void write_head(std::ostream& out) {
  // A section: the word that tells the byte order, version 1.0, a length not known yet.
  write_block(out, 0x0A0D0D0A, std::array{0x1A2B3C4Du, 1u, ~0u, ~0u});
  // Its interface: Ethernet; option 9, if_tsresol, of one byte: 10^-9 s; no more options.
  write_block(out, 1, std::array{1u, kSnap, 9u | 1u << 16, 9u, 0u});
}

std::uint64_t stamp_of(msghdr& message) {
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec t{};
    std::memcpy(&t, CMSG_DATA(c), sizeof t);
    return static_cast<std::uint64_t>(t.tv_sec) * 1'000'000'000 +
           static_cast<std::uint64_t>(t.tv_nsec);
  }
  return 0;
}

}  // namespace

Capture::Capture(const std::string& path, std::uint32_t domain)
    : socket_(open_loopback()), wake_(eventfd(0, EFD_CLOEXEC)), file_(path, std::ios::binary) {
  if (!file_) {
    close(socket_);
    close(wake_);
    throw Failure("--capture: " + path + ": cannot be written");
  }
  // RTPS 9.6.1.1: 250 ports for each domain, from 7400.
  for (std::uint32_t port = 7400 + 250 * domain; port < 7400 + 250 * (domain + 2); ++port)
    ports_.insert(static_cast<std::uint16_t>(port));
  write_head(file_);
  thread_ = std::thread([this] { listen(); });
}

Capture::~Capture() {
  stop();
  close(socket_);
  close(wake_);
}

Capture::Outcome Capture::stop() {
  if (!thread_.joinable()) return outcome_;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_, &one, sizeof one);
  thread_.join();
  tpacket_stats stats{};
  socklen_t size = sizeof stats;
  if (getsockopt(socket_, SOL_PACKET, PACKET_STATISTICS, &stats, &size) == 0)
    outcome_.missed = stats.tp_drops;
  file_.flush();
  return outcome_;
}

void Capture::listen() {
  std::array<pollfd, 2> wait{{{socket_, POLLIN, 0}, {wake_, POLLIN, 0}}};
  for (;;) {
    poll(wait.data(), wait.size(), -1);
    while (receive()) {
    }
    if (wait[1].revents) return;
  }
}

/// One packet; false when there is none.
bool Capture::receive() {
  static thread_local std::vector<std::uint8_t> frame(kSnap);
  std::array<std::uint8_t, 256> control{};
  sockaddr_ll from{};
  iovec data{frame.data(), frame.size()};
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t n = recvmsg(socket_, &message, MSG_TRUNC);
  if (n < 0) return false;
  // The loopback shows each packet twice: leaving, and arriving.
  if (from.sll_pkttype == PACKET_OUTGOING) return true;
  const auto on_wire = static_cast<std::size_t>(n);
  const std::size_t size = std::min(on_wire, frame.size());
  if (is_ours(frame.data(), size)) write(frame.data(), size, on_wire, stamp_of(message));
  return true;
}

bool Capture::is_ours(const std::uint8_t* frame, std::size_t size) {
  const std::size_t udp = kIpAt + 4 * std::size_t{frame[kIpAt] & 0xFu};
  if (udp + kUdpHeader > size) return false;
  const auto port = [&](std::size_t at) {
    return static_cast<std::uint16_t>(frame[at] << 8 | frame[at + 1]);
  };
  const std::uint16_t from = port(udp), to = port(udp + 2);
  if (!ports_.contains(from) && !ports_.contains(to)) return false;
  ports_.insert(from);
  ports_.insert(to);
  return true;
}

void Capture::write(const std::uint8_t* frame, std::size_t size, std::size_t on_wire,
                    std::uint64_t time_ns) {
  const std::array words{0u, static_cast<std::uint32_t>(time_ns >> 32),
                         static_cast<std::uint32_t>(time_ns), static_cast<std::uint32_t>(size),
                         static_cast<std::uint32_t>(on_wire)};
  write_block(file_, 6, words, {frame, size});
  ++outcome_.packets;
}

}  // namespace muster::command
