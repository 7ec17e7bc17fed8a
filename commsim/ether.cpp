#include "commsim/ether.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/core/error.h"

namespace muster::commsim {
namespace {

constexpr std::array<const char*, kDrops> kDropNames{
    "none", "range", "wall", "dead", "scripted", "loss", "airtime", "jam", "cut", "paused", "pose"};

Drop physical(const radio::Reception& reception) {
  switch (reception.link) {
    case radio::Link::kUp:
      return Drop::kNone;
    case radio::Link::kRange:
      return Drop::kRange;
    case radio::Link::kWall:
      return Drop::kWall;
  }
  broken_invariant("a link is up, out of range or behind a wall", __FILE__, __LINE__);
}

}  // namespace

const char* to_string(Drop reason) { return kDropNames.at(static_cast<std::size_t>(reason)); }

Ether::Ether(const radio::ChannelConfig& config, radio::Obstacles obstacles, std::uint64_t seed,
             std::uint32_t hops, std::size_t robots)
    : channel_(config, std::move(obstacles), seed),
      airtime_(config),
      hops_(hops),
      robots_(robots),
      pairs_(robots * robots) {}

const radio::Reception& Ether::reception(std::size_t from, std::size_t to,
                                         const std::vector<Place>& places) {
  const auto [i, j] = std::minmax(from, to);
  const Place &a = places[i], &b = places[j];
  Pair& pair = pairs_[i * robots_ + j];
  if (!pair.known || pair.a != a.p || pair.b != b.p) {
    const radio::Channel::Path path = channel_.path(a.robot, a.p, b.robot, b.p);
    pair = {true, a.p, b.p, channel_.hear(path, a.robot, b.robot),
            channel_.hear(path, b.robot, a.robot)};
  }
  return from < to ? pair.at_b : pair.at_a;
}

/// Why nothing of what `from` sends can arrive at `to`, both alive. What nature does not take,
/// faults may.
Drop Ether::obstacle(std::size_t from, std::size_t to, const std::vector<Place>& places) {
  const Drop nature = physical(reception(from, to, places));
  if (nature != Drop::kNone) return nature;
  if (places[from].jammed || places[to].jammed) return Drop::kJam;
  if (interference_ && interference_->cuts(places[from].robot, places[to].robot)) return Drop::kCut;
  return Drop::kNone;
}

std::vector<std::size_t> Ether::ears(std::size_t from, const std::vector<Place>& places) {
  std::vector<std::size_t> out;
  for (std::size_t to = 0; to < robots_; ++to) {
    if (to != from && places[to].alive() && obstacle(from, to, places) == Drop::kNone) {
      out.push_back(to);
    }
  }
  return out;
}

/// Why those do not hear that are out of the sender's own reach.
void Ether::out_of_reach(std::size_t sender, const std::vector<Place>& places,
                         std::vector<Verdict>& verdicts) {
  for (std::size_t to = 0; to < robots_; ++to) {
    if (to == sender) continue;
    verdicts[to].drop = places[to].alive() ? obstacle(sender, to, places) : places[to].absence();
  }
}

std::vector<Verdict> Ether::send(std::size_t sender, std::uint64_t n, std::size_t bytes,
                                 const std::vector<Place>& places, SimTime now) {
  std::vector<Verdict> verdicts(robots_);
  if (!places[sender].alive()) {
    for (Verdict& verdict : verdicts) verdict.drop = places[sender].absence();
    return verdicts;
  }
  out_of_reach(sender, places, verdicts);
  std::vector<bool> has_it(robots_);
  has_it[sender] = true;
  std::vector<Holder> holders{{sender, now}};
  for (std::uint32_t hop = 0; hop < hops_ && !holders.empty(); ++hop) {
    std::vector<Holder> next;
    for (const Holder& holder : holders) {
      broadcast(holder, {n, bytes}, places, has_it, verdicts, next);
    }
    holders = std::move(next);
  }
  return verdicts;
}

void Ether::broadcast(const Holder& from, const Parcel& parcel, const std::vector<Place>& places,
                      std::vector<bool>& has_it, std::vector<Verdict>& verdicts,
                      std::vector<Holder>& next) {
  const RobotId sender = places[from.robot].robot;
  const double least_loss = interference_ ? interference_->loss() : 0;
  const std::vector<std::size_t> hearers = ears(from.robot, places);
  std::vector<RobotId> around;
  around.reserve(hearers.size());
  for (const std::size_t to : hearers) around.push_back(places[to].robot);
  const auto sent = airtime_.send(sender, around, from.at, parcel.bytes);
  for (const std::size_t to : hearers) {
    if (has_it[to]) continue;
    Verdict& verdict = verdicts[to];
    if (!sent) {
      verdict.drop = Drop::kAirtime;
    } else if (channel_.is_lost(reception(from.robot, to, places), sender, parcel.n,
                                places[to].robot, parcel.bytes, least_loss)) {
      verdict.drop = Drop::kLoss;
    } else {
      verdict = {Drop::kNone, *sent + Duration::from_s(channel_.config().latency_ms * 1e-3)};
      has_it[to] = true;
      next.push_back({to, verdict.heard});
    }
  }
}

}  // namespace muster::commsim
