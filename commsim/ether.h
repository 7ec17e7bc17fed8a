#pragma once

#include <cstdint>
#include <vector>

#include "common/core/ids.h"
#include "common/core/time.h"
#include "common/geometry/pose.h"
#include "common/radio/airtime.h"
#include "common/radio/channel.h"
#include "commsim/interference.h"

namespace muster::commsim {

/// Why a message was not heard.
enum class Drop : std::uint8_t {
  kNone,
  kRange,
  kWall,
  kDead,
  kScripted,
  kLoss,
  kAirtime,
  kJam,
  kCut,
  kPaused,
  kPose,
};
inline constexpr std::size_t kDrops = 11;
const char* to_string(Drop reason);

/// A robot as the radio sees it.
struct Place {
  RobotId robot;
  Vec3 p = Vec3::Zero();
  bool process_alive = true, vehicle_alive = true;
  bool paused = false, jammed = false;
  bool located = true;  ///< `p` is where it is; not so in a lab that lost sight of it
  bool alive() const { return process_alive && vehicle_alive && !paused && located; }
  /// Why it hears nothing, and is not heard, when it is not alive.
  Drop absence() const {
    if (paused) return Drop::kPaused;
    return located ? Drop::kDead : Drop::kPose;
  }
};

/// What became of a message at one receiver.
struct Verdict {
  Drop drop = Drop::kDead;
  SimTime heard;  ///< when, unless dropped
};

/// One radio of a fleet: puts messages on air, one after the other, and says who hears them when.
/// Robots are told apart by their index in a list that stays the same, ascending by id.
///
/// With several hops whoever hears a message sends it on once, as far as hops go; each such
/// transmission takes its airtime.
class Ether {
 public:
  Ether(const radio::ChannelConfig& config, radio::Obstacles obstacles, std::uint64_t seed,
        std::uint32_t hops, std::size_t robots);

  /// Whether it matters in which order messages are sent.
  bool shared() const { return airtime_.limited(); }
  /// One verdict per robot, the sender's own without meaning.
  std::vector<Verdict> send(std::size_t sender, std::uint64_t n, std::size_t bytes,
                            const std::vector<Place>& places, SimTime now);
  /// What is cut and lost from now on besides what nature takes; jams and pauses are in places.
  /// Outlives this.
  void disturb(const Interference& interference) { interference_ = &interference; }

 private:
  /// A pair's link, good while neither moves.
  struct Pair {
    bool known = false;
    Vec3 a, b;
    radio::Reception at_b, at_a;
  };
  const radio::Reception& reception(std::size_t from, std::size_t to,
                                    const std::vector<Place>& places);
  /// Who has the message, and since when.
  struct Holder {
    std::size_t robot;
    SimTime at;
  };
  struct Parcel {
    std::uint64_t n;
    std::size_t bytes;
  };
  Drop obstacle(std::size_t from, std::size_t to, const std::vector<Place>& places);
  std::vector<std::size_t> ears(std::size_t from, const std::vector<Place>& places);
  void out_of_reach(std::size_t sender, const std::vector<Place>& places,
                    std::vector<Verdict>& verdicts);
  void broadcast(const Holder& from, const Parcel& parcel, const std::vector<Place>& places,
                 std::vector<bool>& has_it, std::vector<Verdict>& verdicts,
                 std::vector<Holder>& next);

  radio::Channel channel_;
  radio::Airtime airtime_;
  std::uint32_t hops_;
  std::size_t robots_;
  std::vector<Pair> pairs_;
  const Interference* interference_ = nullptr;
};

}  // namespace muster::commsim
