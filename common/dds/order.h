#pragma once

#include <vector>

#include "common/mission/messages.h"

namespace muster::dds {

/// Into (src, n) order, the order in which everything acts on what it received: arrival order never
/// matters.
void sort_messages(std::vector<mission::Message>& messages);

}  // namespace muster::dds
