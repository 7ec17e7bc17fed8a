#include "commsim/relay.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "common/core/error.h"
#include "common/core/hash.h"
#include "common/dds/convert.h"
#include "common/dds/order.h"
#include "common/store/journal.h"
#include "commsim/air_log.h"
#include "commsim/contacts.h"
#include "commsim/interference.h"
#include "commsim/promises.h"
#include "commsim/walls.h"

namespace muster::commsim {
namespace {

constexpr std::string_view kMeshSalt = "mesh";

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

struct Relay::Impl {
  Impl(const mission::Mission& mission, const radio::Obstacles& obstacles)
      : script(mission.script),
        interference(mission.script),
        main(mission.radio, obstacles, mission.seed, 1, mission.fleet.size()) {
    for (const mission::RobotConfig& robot : mission.fleet) places.push_back({.robot = robot.id});
    std::ranges::sort(places, {}, &Place::robot);
    if (mission.radio.mesh) {
      mesh.emplace(mission.radio.mesh->channel, obstacles, hash_text(kMeshSalt, mission.seed),
                   mission.radio.mesh->hops, places.size());
    }
    main.disturb(interference);
    if (mesh) mesh->disturb(interference);
  }

  /// A message on its way out, and what became of it at every robot.
  struct Outgoing {
    mission::Envelope envelope;
    const mission::Message* message;
    std::size_t sender;  ///< index in `places`
    std::size_t rank;    ///< among its sender's messages of this tick
    std::vector<Verdict> verdicts;
    bool beacon() const { return envelope.cls == mission::MessageClass::kBeacon; }
  };
  /// What a partition brought in a tick.
  struct Sender {
    RobotId robot;
    std::vector<Outgoing> messages;
    std::vector<std::uint64_t> refused;  ///< hashes
  };
  /// Heard later than in the next tick.
  struct Late {
    std::size_t from, to;
    mission::Message message;
  };

  Place* place_of(RobotId robot) {
    const auto it = std::ranges::lower_bound(places, robot, {}, &Place::robot);
    return it != places.end() && it->robot == robot ? &*it : nullptr;
  }

  void judge(RobotId robot) {
    if (journals) promises.judge_file(robot, store::Journal::path(*journals, robot), stepped);
  }

  void disturb(SimTime now) {
    interference.advance(now);
    for (Place& place : places) {
      place.paused = interference.pauses(place.robot);
      place.jammed = interference.jams(place.p);
    }
  }

  Sender read(RobotId robot, const std::vector<mission::Message>& messages) {
    Sender out{robot, {}, {}};
    const Place* place = place_of(robot);
    for (const mission::Message& message : messages) {
      const auto envelope = checked_envelope(robot, message);
      if (envelope && place) {
        const auto index = static_cast<std::size_t>(place - places.data());
        out.messages.push_back({*envelope, &message, index, 0, {}});
      } else {
        out.refused.push_back(hash_bytes(message.cdr));
      }
    }
    std::ranges::stable_sort(out.messages, {}, [](const Outgoing& m) { return m.envelope.n; });
    for (std::size_t i = 0; i < out.messages.size(); ++i) out.messages[i].rank = i;
    return out;
  }

  /// Puts everything on air, in the order in which the air is granted.
  void send(std::vector<Sender>& senders, std::uint64_t k, SimTime now) {
    std::vector<Outgoing*> order;
    for (Sender& sender : senders) {
      for (Outgoing& message : sender.messages) order.push_back(&message);
    }
    if (main.shared() || (mesh && mesh->shared())) {
      const std::size_t first = k % places.size();
      std::ranges::stable_sort(order, {}, [&](const Outgoing* m) {
        const std::size_t turn = (m->sender + places.size() - first) % places.size();
        return std::tuple(!m->beacon(), m->rank, turn);
      });
    }
    for (Outgoing* m : order) {
      const std::size_t bytes = m->message->cdr.size();
      m->verdicts = main.send(m->sender, m->envelope.n, bytes, places, now);
      if (mesh) add_mesh(*m, mesh->send(m->sender, m->envelope.n, bytes, places, now));
    }
  }

  void add_mesh(Outgoing& m, const std::vector<Verdict>& heard) {
    for (std::size_t i = 0; i < heard.size(); ++i) {
      if (i == m.sender || heard[i].drop != Drop::kNone) continue;
      if (m.verdicts[i].drop == Drop::kNone) {
        m.verdicts[i].heard = std::min(m.verdicts[i].heard, heard[i].heard);
      } else {
        m.verdicts[i] = heard[i];
        ++by_mesh;
      }
    }
  }

  void account(const Outgoing& m, std::uint64_t k, SimTime now, Outcome& out, Hasher& trace) {
    const std::size_t size = m.message->cdr.size();
    const bool scripted = m.beacon() && interference.mutes(m.envelope.src);
    if (journals) promises.sent(m.envelope.src, *m.message);
    sent.add(size);
    by_topic[m.envelope.cls].add(size);
    trace.add(m.envelope.src.value).add(m.envelope.n).add(hash_bytes(m.message->cdr));
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i == m.sender) continue;
      const RobotId to = places[i].robot;
      const Verdict& verdict = m.verdicts[i];
      const bool heard = verdict.drop == Drop::kNone;
      const Drop drop = heard && scripted ? Drop::kScripted : verdict.drop;
      trace.add(to.value).add(drop);
      if (drop != Drop::kNone) {
        ++dropped[static_cast<std::size_t>(drop)];
        if (log) log->dropped(m.sender, i, size, drop);
        continue;
      }
      if (verdict.heard <= now + kTick) {
        deliver(m.sender, i, *m.message, now, out);
      } else {
        const auto ticks = ((verdict.heard - now).us - 1) / kTick.us;
        trace.add(ticks);
        late[k + static_cast<std::uint64_t>(ticks)].push_back({m.sender, i, *m.message});
      }
    }
  }

  void deliver(std::size_t from, std::size_t to, const mission::Message& message, SimTime now,
               Outcome& out) {
    delivered.add(message.cdr.size());
    if (log) log->heard(from, to, message.cdr.size());
    contacts.heard(places[from].robot, places[to].robot, message, now);
    out.deliveries[places[to].robot].push_back(message);
  }

  /// What was sent earlier and is heard only now.
  void deliver_late(std::uint64_t k, SimTime now, Outcome& out) {
    while (!late.empty() && late.begin()->first <= k) {
      for (const Late& l : late.begin()->second) {
        if (places[l.to].alive()) {
          deliver(l.from, l.to, l.message, now, out);
        } else {
          const Drop reason = places[l.to].absence();
          ++dropped[static_cast<std::size_t>(reason)];
          if (log) log->dropped(l.from, l.to, l.message.cdr.size(), reason);
        }
      }
      late.erase(late.begin());
    }
  }

  const std::vector<mission::ScriptedEvent> script;
  std::vector<Place> places;  // ascending
  Interference interference;
  std::optional<std::string> journals;  // the directory that has them
  Promises promises;
  SimTime stepped;  // when last
  std::map<RobotId, SimTime> died;
  Ether main;
  std::optional<Ether> mesh;
  std::map<std::uint64_t, std::vector<Late>> late;  // by the tick whose outcome they belong to
  Contacts contacts;
  std::optional<AirLog> log;
  Count sent, delivered;
  std::uint64_t refused = 0, by_mesh = 0;
  std::array<std::uint64_t, kDrops> dropped{};
  std::map<mission::MessageClass, Count> by_topic;
};

Relay::Relay(const mission::Mission& mission, const std::shared_ptr<const world::Scene>& scene)
    : Relay(mission,
            radio::Obstacles{
                .line_of_sight = [scene](const Vec3& a,
                                         const Vec3& b) { return scene->line_of_sight(a, b); },
                .walls = [scene](const Vec3& a,
                                 const Vec3& b) { return walls_between(*scene, a, b); }}) {}

Relay::Relay(const mission::Mission& mission, radio::LineOfSight line_of_sight)
    : Relay(mission, radio::Obstacles{std::move(line_of_sight)}) {}

Relay::Relay(const mission::Mission& mission, const radio::Obstacles& obstacles)
    : impl_(std::make_unique<Impl>(mission, obstacles)) {}

Relay::~Relay() = default;

Relay::Outcome Relay::step(const mission::Truth& truth,
                           const std::map<RobotId, std::vector<mission::Message>>& sent) {
  for (const mission::TrueState& state : truth.robots) {
    if (Place* place = impl_->place_of(state.robot)) {
      place->p = state.pose.p;
      place->vehicle_alive = state.state != mission::VehicleState::kDead;
    }
  }
  impl_->stepped = truth.time;
  impl_->disturb(truth.time);
  if (impl_->log) impl_->log->advance(truth.time);
  std::vector<Impl::Sender> senders;
  senders.reserve(sent.size());
  for (const auto& [robot, messages] : sent) senders.push_back(impl_->read(robot, messages));
  impl_->send(senders, truth.k, truth.time);

  Outcome out;
  Hasher trace;
  trace.add(truth.k);
  impl_->deliver_late(truth.k, truth.time, out);
  const bool merged = !out.deliveries.empty();
  for (const Impl::Sender& sender : senders) {
    impl_->refused += sender.refused.size();
    for (const std::uint64_t hash : sender.refused) trace.add(sender.robot.value).add(hash);
    for (const Impl::Outgoing& m : sender.messages) {
      impl_->account(m, truth.k, truth.time, out, trace);
    }
  }
  if (merged) {
    for (auto& [to, messages] : out.deliveries) dds::sort_messages(messages);
  }
  out.trace = trace.value();
  out.met = impl_->contacts.take_meetings();
  return out;
}

void Relay::set_alive(RobotId robot, bool alive) {
  Place* place = impl_->place_of(robot);
  if (!place || place->process_alive == alive) return;
  place->process_alive = alive;
  if (!alive) {
    impl_->judge(robot);
    impl_->died[robot] = impl_->stepped;
  } else if (mission::lost_journal(impl_->script, robot, impl_->died[robot],
                                   impl_->stepped + kTick)) {
    impl_->promises.disk_lost(robot);
  }
}

void Relay::set_located(RobotId robot, bool located) {
  if (Place* place = impl_->place_of(robot)) place->located = located;
}

void Relay::judge_journals_in(const std::string& dir) { impl_->journals = dir; }

void Relay::log_to(const std::string& path) {
  std::vector<RobotId> robots;
  for (const Place& place : impl_->places) robots.push_back(place.robot);
  impl_->log.emplace(path, std::move(robots));
}

void Relay::finish() {
  for (const Place& place : impl_->places) impl_->judge(place.robot);
  if (impl_->log) impl_->log->finish();
}

nlohmann::json Relay::summary() const {
  nlohmann::json dropped = nlohmann::json::object(), topics = nlohmann::json::object();
  for (std::size_t i = 1; i < kDrops; ++i)
    dropped[to_string(static_cast<Drop>(i))] = impl_->dropped[i];
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
            {"by_mesh", impl_->by_mesh},
            {"by_topic", std::move(topics)}}},
          {"records_lost", impl_->journals ? impl_->promises.to_json() : nlohmann::json(nullptr)},
          {"contacts", impl_->contacts.to_json()}};
}

}  // namespace muster::commsim
