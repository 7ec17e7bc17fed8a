#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/mission/messages.h"
#include "common/mission/mission.h"
#include "commsim/world/scene.h"

namespace muster::commsim {

/// Why a message was not heard.
enum class Drop : std::uint8_t { kNone, kRange, kWall, kDead, kScripted };
const char* to_string(Drop reason);

/// The radio as a pure core: per message and receiver it decides by range and line of sight on the
/// true poses of the tick, in the fixed order (src, n, receiver). Reads envelopes only; bytes pass
/// untouched.
class Relay {
 public:
  Relay(const mission::Mission& mission, std::shared_ptr<const world::Scene> scene);
  ~Relay();

  struct Outcome {
    std::map<RobotId, std::vector<mission::Message>>
        deliveries;           ///< per destination, in (src, n) order, for tick k + 1
    std::uint64_t trace = 0;  ///< sends and deliveries with reasons of this tick
  };
  /// `sent`: everything sent on air in this tick, per sender's partition; refuses (and counts)
  /// messages whose envelope is not the sender's.
  Outcome step(const mission::Truth& truth,
               const std::map<RobotId, std::vector<mission::Message>>& sent);

  void set_alive(RobotId robot, bool alive);
  nlohmann::json summary()
      const;  ///< air{bytes, delivered, dropped{reason}} and contact intervals per pair

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace muster::commsim
