// A mission file: somebody's YAML.
#include "common/mission/mission.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  const fuzz::MemoryFile file(data, size);
  fuzz::refuses_or_reads([&] { mission::Mission::load(file.path()).to_yaml(); });
  return 0;
}
