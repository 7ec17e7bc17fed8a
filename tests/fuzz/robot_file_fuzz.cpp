// A robot's own file, /etc/muster/<id>.yaml.
#include "common/mission/robot_file.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  const fuzz::MemoryFile file(data, size);
  fuzz::refuses_or_reads([&] { mission::RobotFile::load(file.path()); });
  return 0;
}
