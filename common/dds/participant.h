#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/mission/messages.h"

/// Both DDS vendors behind one small interface that moves CDR bytes. No vendor type appears here.
namespace muster::dds {

enum class Vendor { kCyclone, kFast };
/// "cyclonedds" | "fastdds". Throws BadInput.
Vendor vendor_from(const std::string& name);
const char* to_string(Vendor vendor);

/// One table of QoS and transport each (DESIGN "Profiles").
enum class Profile { kSimLocalhost, kWired, kWifiUnicast };
Profile profile_from(const std::string& name);  // "sim-localhost" | "wired" | "wifi-unicast"

struct ParticipantConfig {
  Vendor vendor = Vendor::kCyclone;
  Profile profile = Profile::kSimLocalhost;
  std::uint32_t domain = 0;       ///< below 100
  std::uint32_t participant = 0;  ///< unique in the domain; 0 is the hub (robot id + 1 for robots)
  bool star =
      true;  ///< sim-localhost: know only the hub as initial peer; false: everyone finds everyone
  std::string network_interface;  ///< address or name; empty: loopback for sim-localhost, else the
                                  ///< vendor's choice
  std::vector<std::string>
      peers;  ///< static peers (host names or addresses), for wired and wifi-unicast
  /// Test switch, 0: off. Received messages are held back for a random moment and handed over out
  /// of order. Also set for a whole process by the environment variable
  /// MUSTER_DDS_SHUFFLE=<number>.
  std::uint64_t shuffle_seed = 0;
};

/// How a topic endpoint behaves within its profile.
enum class Delivery {
  kLatest,      ///< keep-last 1, reliable in sim: state that is replaced (tick, truth, odometry)
  kEvery,       ///< nothing may be dropped while the reader lives: deep keep-last, never blocks
                ///< (deliveries, scans, done)
  kBestEffort,  ///< as the air profile in the field
};

class Writer {
 public:
  virtual ~Writer() = default;
  /// `cdr` with its 4 bytes of encapsulation and, as convert makes it, of a length that is a
  /// multiple of 4. Thread-safe; never waits for a reader. Throws Failure when the middleware
  /// refuses.
  virtual void write(ByteView cdr) = 0;
  virtual int matched() const = 0;  ///< readers matched now
};

class Reader {
 public:
  virtual ~Reader() = default;
  virtual int matched() const = 0;  ///< writers matched now
};

/// Called on a middleware thread for every sample, in the order of each writer. Must only queue.
using OnMessage = std::function<void(mission::Message&&)>;
/// Called on a middleware thread when an endpoint's match count changes.
using OnMatch = std::function<void()>;

/// Matching is not mutual: a writer may count a reader that does not know the writer yet, and what
/// is written in that moment is lost to it. So before data that must arrive, both sides look at
/// their own counts and tell each other: in the simulator every process repeats Done{k = 0} until
/// the first tick, from when all of its own endpoints are matched.
///
/// Writers and readers are destroyed before their participant. Destroying a reader waits for its
/// running callback; afterwards there is none. As over radio, a participant does not hear itself.
class Participant {
 public:
  virtual ~Participant() = default;
  virtual std::unique_ptr<Writer> writer(mission::MessageClass topic, const std::string& partition,
                                         Delivery delivery, OnMatch on_match = {}) = 0;
  /// `partition` may hold wildcards ("up.*").
  virtual std::unique_ptr<Reader> reader(mission::MessageClass topic, const std::string& partition,
                                         Delivery delivery, OnMessage on_message,
                                         OnMatch on_match = {}) = 0;
};

/// Throws Failure when the domain's port is taken (the hub) or the interface does not exist;
/// BadInput for a domain ≥ 100.
std::unique_ptr<Participant> make_participant(const ParticipantConfig& config);

// Partitions (DESIGN "The picture").
std::string up_partition(RobotId id);    // "up.<id>"   robot → radio
std::string down_partition(RobotId id);  // "down.<id>" radio → robot
std::string bus_partition(RobotId id);   // "bus.<id>"
inline constexpr const char* kSimPartition = "sim";
inline constexpr const char* kAirPartition = "air";  // --link direct and the field: everybody

}  // namespace muster::dds
