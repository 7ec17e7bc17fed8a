#pragma once

#include <dds/dds.h>

#include "common/dds/participant.h"

namespace muster::dds {

/// Cyclone's configuration belongs to a domain, not to a participant, and a process has each domain
/// once. So participants of one domain share it, and the first one's configuration counts; the last
/// one out deletes it.
class CycloneDomain {
 public:
  /// Throws Failure when Cyclone refuses, or when a hub joins a domain that this process already
  /// has without being its hub.
  explicit CycloneDomain(const ParticipantConfig& config);
  ~CycloneDomain();
  CycloneDomain(const CycloneDomain&) = delete;
  CycloneDomain& operator=(const CycloneDomain&) = delete;

 private:
  std::uint32_t id_;
};

}  // namespace muster::dds
