// A scene's recipe: somebody's YAML (deploy/scenes/README.md).
#include "commsim/world/generator.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  const fuzz::MemoryFile file(data, size);
  fuzz::refuses_or_reads([&] { world::generate(file.path()); });
  return 0;
}
