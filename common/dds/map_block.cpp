#include "common/dds/map_block.h"

#include <cmath>
#include <string>

#include "common/core/error.h"
#include "common/map/block_codec.h"

namespace muster::dds {

mission::MapBlock map_block(std::span<const map::SaidBlock> said, double resolution_m) {
  return {static_cast<float>(resolution_m), mission::BlockEncoding::kArithmetic,
          map::encode_blocks(said)};
}

std::vector<map::SaidBlock> said_blocks(const mission::MapBlock& record, double resolution_m) {
  if (std::abs(static_cast<double>(record.resolution_m) - resolution_m) > 1e-4) {
    throw BadInput("map block: resolution_m is not the mission's");
  }
  if (record.encoding != mission::BlockEncoding::kArithmetic) {
    throw BadInput("map block: encoding " +
                   std::to_string(static_cast<std::uint32_t>(record.encoding)) +
                   " is not known here, only 2 (arithmetic)");
  }
  return map::decode_blocks(record.blocks);
}

}  // namespace muster::dds
