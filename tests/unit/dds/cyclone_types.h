#pragma once

#include <dds/dds.h>

#include "common/mission/messages.h"

namespace muster::test {

/// idlc's descriptor of a message. (Its header and fastddsgen's have one name, so only
/// cyclone_types.cpp sees it.)
const dds_topic_descriptor_t* cyclone_descriptor(mission::MessageClass cls);

}  // namespace muster::test
