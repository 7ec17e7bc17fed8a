// Words on blocks of map, as another robot sent them.
#include "common/map/block_codec.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  const ByteView bytes(data, size);
  fuzz::refuses_or_reads([&] {
    // What was read can be written, and is read again as it was.
    const Bytes again = map::encode_blocks(map::decode_blocks(bytes));
    if (map::encode_blocks(map::decode_blocks(again)) != again) __builtin_trap();
  });
  return 0;
}
