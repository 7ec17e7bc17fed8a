#include "tests/unit/dds/cyclone_types.h"

// Declared here instead of included: both vendors generate an air.h.
extern "C" {
#define MUSTER_DECLARE(module, Name) \
  extern const dds_topic_descriptor_t muster_##module##_##Name##_desc;
#define MUSTER_EACH_TYPE(DO) \
  DO(air, Beacon)            \
  DO(air, MapBlock)          \
  DO(air, Area)              \
  DO(air, Inspection)        \
  DO(air, Plan)              \
  DO(air, Meeting)           \
  DO(air, Status)            \
  DO(air, ExchangeEnd)       \
  DO(bus, Odometry)          \
  DO(bus, Scan)              \
  DO(bus, Sightings)         \
  DO(bus, Battery)           \
  DO(bus, Inspected)         \
  DO(bus, OperatorRequest)   \
  DO(bus, Trajectory) DO(bus, Inspect) DO(bus, Charge) DO(sim, Tick) DO(sim, Done) DO(sim, Truth)
MUSTER_EACH_TYPE(MUSTER_DECLARE)
}

namespace muster::test {

const dds_topic_descriptor_t* cyclone_descriptor(mission::MessageClass cls) {
#define MUSTER_RETURN(module, Name) \
  if (cls == mission::MessageClass::k##Name) return &muster_##module##_##Name##_desc;
  MUSTER_EACH_TYPE(MUSTER_RETURN)
  return nullptr;
}

}  // namespace muster::test
