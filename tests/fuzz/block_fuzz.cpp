// A block of map as another robot sent it.
#include "common/map/block.h"
#include "common/map/block_codec.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  const ByteView bytes(data, size);
  fuzz::refuses_or_reads([&] { map::decode_states(bytes); });
  return 0;
}
