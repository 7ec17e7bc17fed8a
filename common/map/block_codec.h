#pragma once

#include "common/map/block.h"

namespace muster::map {

/// An encoded block as planes, without a stop at 4096 separate voxels. Throws BadInput.
States decode_states(ByteView zstd_2bit);

}  // namespace muster::map
