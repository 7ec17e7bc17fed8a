#pragma once

#include <cstdint>
#include <fstream>
#include <set>
#include <string>
#include <thread>

namespace muster::command {

/// Writes this run's RTPS packets on the loopback interface to a pcapng file, discovery included,
/// for Wireshark with muster.lua.
///
/// Other runs on this computer speak RTPS as well. Ours is told apart by ports: those of our two
/// domains are known, and whoever speaks with one of ours is ours, so start before the first
/// participant does.
class Capture {
 public:
  /// `domain` of the bus; the air has the next one. Throws Failure when packets may not be listened
  /// to (it takes CAP_NET_RAW) or the file cannot be written.
  Capture(const std::string& path, std::uint32_t domain);
  ~Capture();
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  struct Outcome {
    std::uint64_t packets = 0;
    std::uint64_t missed = 0;  ///< came faster than they could be written
  };
  /// Writes what has come and ends.
  Outcome stop();

 private:
  void listen();
  bool receive();
  bool is_ours(const std::uint8_t* frame, std::size_t size);
  void write(const std::uint8_t* frame, std::size_t size, std::size_t on_wire,
             std::uint64_t time_ns);

  int socket_ = -1, wake_ = -1;
  std::ofstream file_;
  std::set<std::uint16_t> ports_;
  Outcome outcome_;
  std::thread thread_;
};

}  // namespace muster::command
