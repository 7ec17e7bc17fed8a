#include "commsim/relay.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <utility>

#include "common/core/error.h"
#include "common/core/hash.h"
#include "common/dds/convert.h"
#include "commsim/contacts.h"

namespace muster::commsim {
namespace {

constexpr std::array<const char*, kDrops> kDropNames{"none", "range", "wall", "dead", "scripted"};

radio::ChannelConfig channel_config(const mission::Mission& mission) {
  return {mission.radio.range_m, mission.radio.line_of_sight, mission.radio.always_on};
}

Drop drop_of(radio::Link link) {
  switch (link) {
    case radio::Link::kUp:
      return Drop::kNone;
    case radio::Link::kRange:
      return Drop::kRange;
    case radio::Link::kWall:
      return Drop::kWall;
  }
  broken_invariant("a link is up, out of range or behind a wall", __FILE__, __LINE__);
}

struct Count {
  std::uint64_t messages = 0, bytes = 0;

  void add(std::size_t size) {
    ++messages;
    bytes += size;
  }
};

/// The envelope, when it is the sender's own and of the topic that the message came on.
std::optional<mission::Envelope> checked_envelope(RobotId sender, const mission::Message& message) {
  try {
    const mission::Envelope e = dds::peek_envelope(message.cdr);
    if (e.src == sender && e.cls == message.cls && mission::is_air(e.cls)) return e;
  } catch (const BadInput&) {
    // Too short to hold an envelope: refused like any other that is not the sender's.
  }
  return std::nullopt;
}

}  // namespace

const char* to_string(Drop reason) { return kDropNames.at(static_cast<std::size_t>(reason)); }

struct Relay::Impl {
  Impl(const mission::Mission& mission, radio::LineOfSight line_of_sight)
      : channel(channel_config(mission), std::move(line_of_sight)) {
    for (const mission::RobotConfig& robot : mission.fleet) places.try_emplace(robot.id);
    for (const mission::ScriptedEvent& event : mission.script) {
      if (event.verb == "mute-beacons") mutes.push_back(event);
    }
  }

  struct Place {
    Vec3 p = Vec3::Zero();
    bool process_alive = true, vehicle_alive = true;
    bool alive() const { return process_alive && vehicle_alive; }
  };
  /// A pair's link, good while neither moves.
  struct CachedLink {
    Vec3 a = Vec3::Zero(), b = Vec3::Zero();
    radio::Link link{};
  };

  radio::Link link(RobotId x, const Vec3& px, RobotId y, const Vec3& py) {
    const bool in_order = x < y;
    const auto [a, b] = in_order ? std::pair(x, y) : std::pair(y, x);
    const Vec3& pa = in_order ? px : py;
    const Vec3& pb = in_order ? py : px;
    const auto [it, fresh] = links.try_emplace({a, b});
    CachedLink& cached = it->second;
    if (fresh || cached.a != pa || cached.b != pb) {
      cached = {pa, pb, channel.between(a, pa, b, pb)};
    }
    return cached.link;
  }

  bool muted(RobotId robot, SimTime now) const {
    return std::ranges::any_of(mutes, [&](const mission::ScriptedEvent& e) {
      return e.at <= now && (e.robot == robot || e.robot == kNoRobot);
    });
  }

  Drop decide(const mission::Envelope& envelope, const Place& from, RobotId to, const Place& at,
              bool scripted) {
    if (!from.alive() || !at.alive()) return Drop::kDead;
    const Drop physical = drop_of(link(envelope.src, from.p, to, at.p));
    return physical == Drop::kNone && scripted ? Drop::kScripted : physical;
  }

  void relay(const mission::Envelope& envelope, const mission::Message& message, SimTime now,
             Outcome& out, Hasher& trace) {
    const std::size_t size = message.cdr.size();
    const Place& from = places.at(envelope.src);
    const bool beacon = envelope.cls == mission::MessageClass::kBeacon;
    const bool scripted = beacon && muted(envelope.src, now);
    sent.add(size);
    by_topic[envelope.cls].add(size);
    trace.add(envelope.src.value).add(envelope.n).add(hash_bytes(message.cdr));
    for (const auto& [to, at] : places) {
      if (to == envelope.src) continue;
      const Drop drop = decide(envelope, from, to, at, scripted);
      trace.add(to.value).add(drop);
      if (drop != Drop::kNone) {
        ++dropped[static_cast<std::size_t>(drop)];
        continue;
      }
      delivered.add(size);
      if (beacon) contacts.beacon_heard(envelope.src, to, now);
      out.deliveries[to].push_back(message);
    }
  }

  radio::Channel channel;
  std::map<RobotId, Place> places;
  std::map<std::pair<RobotId, RobotId>, CachedLink> links;
  std::vector<mission::ScriptedEvent> mutes;
  Contacts contacts;
  Count sent, delivered;
  std::uint64_t refused = 0;
  std::array<std::uint64_t, kDrops> dropped{};
  std::map<mission::MessageClass, Count> by_topic;
};

Relay::Relay(const mission::Mission& mission, std::shared_ptr<const world::Scene> scene)
    : Relay(mission, radio::LineOfSight([scene = std::move(scene)](const Vec3& a, const Vec3& b) {
              return scene->line_of_sight(a, b);
            })) {}

Relay::Relay(const mission::Mission& mission, radio::LineOfSight line_of_sight)
    : impl_(std::make_unique<Impl>(mission, std::move(line_of_sight))) {}

Relay::~Relay() = default;

Relay::Outcome Relay::step(const mission::Truth& truth,
                           const std::map<RobotId, std::vector<mission::Message>>& sent) {
  for (const mission::TrueState& state : truth.robots) {
    const auto it = impl_->places.find(state.robot);
    if (it == impl_->places.end()) continue;
    it->second.p = state.pose.p;
    it->second.vehicle_alive = state.state != mission::VehicleState::kDead;
  }
  Outcome out;
  Hasher trace;
  trace.add(truth.k);
  for (const auto& [sender, messages] : sent) {
    std::vector<std::pair<mission::Envelope, const mission::Message*>> in_order;
    in_order.reserve(messages.size());
    for (const mission::Message& message : messages) {
      const auto envelope = checked_envelope(sender, message);
      if (envelope && impl_->places.contains(sender)) {
        in_order.emplace_back(*envelope, &message);
      } else {
        ++impl_->refused;
        trace.add(sender.value).add(hash_bytes(message.cdr));
      }
    }
    std::ranges::stable_sort(in_order, {}, [](const auto& m) { return m.first.n; });
    for (const auto& [envelope, message] : in_order) {
      impl_->relay(envelope, *message, truth.time, out, trace);
    }
  }
  out.trace = trace.value();
  return out;
}

void Relay::set_alive(RobotId robot, bool alive) {
  const auto it = impl_->places.find(robot);
  if (it != impl_->places.end()) it->second.process_alive = alive;
}

nlohmann::json Relay::summary() const {
  nlohmann::json dropped = nlohmann::json::object(), topics = nlohmann::json::object();
  for (std::size_t i = 1; i < kDrops; ++i) dropped[kDropNames[i]] = impl_->dropped[i];
  for (const auto& [cls, count] : impl_->by_topic) {
    topics[mission::topic_name(cls)] = {{"messages", count.messages}, {"bytes", count.bytes}};
  }
  return {{"air",
           {{"messages", impl_->sent.messages},
            {"bytes", impl_->sent.bytes},
            {"delivered", impl_->delivered.messages},
            {"delivered_bytes", impl_->delivered.bytes},
            {"refused", impl_->refused},
            {"dropped", std::move(dropped)},
            {"by_topic", std::move(topics)}}},
          {"contacts", impl_->contacts.to_json()}};
}

}  // namespace muster::commsim
