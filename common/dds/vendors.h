#pragma once

#include <memory>
#include <optional>

#include "common/dds/network.h"
#include "common/dds/participant.h"

/// The two implementations behind make_participant, which has checked `config`.
namespace muster::dds {

std::unique_ptr<Participant> make_cyclone_participant(const ParticipantConfig& config);
std::unique_ptr<Participant> make_fast_participant(const ParticipantConfig& config);

inline bool is_hub(const ParticipantConfig& c) {
  return c.profile == Profile::kSimLocalhost && c.star && c.participant == 0;
}
inline bool is_star_agent(const ParticipantConfig& c) {
  return c.profile == Profile::kSimLocalhost && c.star && c.participant != 0;
}
/// The ports by which others find this participant; none for who is told by the hub.
inline std::optional<PortClaim> claim_ports(const ParticipantConfig& c) {
  if (is_star_agent(c)) return std::nullopt;
  if (is_hub(c)) return PortClaim(c.domain, 0);
  const bool mesh = c.profile == Profile::kSimLocalhost;
  return PortClaim::first_free(c.domain, mesh ? kMeshOnLocalhost : kPerHost);
}

/// Samples a writer keeps for slow readers, and a reader for a slow listener. Nothing is allocated
/// ahead.
inline constexpr int kDeepHistory = 4096;

/// Whether an endpoint repeats what was lost. On air in the field nothing does: the record exchange
/// is there for that.
inline bool is_reliable(Profile profile, mission::MessageClass topic, Delivery delivery) {
  if (delivery == Delivery::kBestEffort) return false;
  return profile == Profile::kSimLocalhost || !mission::is_air(topic);
}

/// No message of ours is as short as a CDR header alone; a Fast writer greets with it
/// (fast_greeter.h).
inline constexpr std::size_t kGreetingSize = 4;

/// Longest RTPS message in bytes. Over a radio no IP fragments: one lost fragment would lose all.
inline std::uint32_t longest_message(Profile profile) {
  return profile == Profile::kSimLocalhost ? 65000 : 1400;
}

}  // namespace muster::dds
