// A robot's journal as a crash, a bad disk or somebody else may have left it.
#include <filesystem>
#include <fstream>
#include <string>

#include "common/store/journal.h"
#include "tests/fuzz/fuzz.h"

namespace {

/// In memory where there is such a place: the disk is not what is looked at.
std::string place() {
  const char* dir = std::filesystem::is_directory("/dev/shm") ? "/dev/shm" : "/tmp";
  return dir + std::string("/muster_fuzz_") + std::to_string(getpid()) + ".db";
}

void remove_all_of(const std::string& path) {
  for (const char* end : {"", "-wal", "-shm", "-journal", ".damaged"})
    std::filesystem::remove(path + end);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  static const std::string path = place();
  remove_all_of(path);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    store::Journal journal(path, RobotId{1}, store::Journal::Durability::kProcess);
    store::RecordStore records(RobotId{1}, journal.epoch() + 1);
    journal.restore(records, [](const store::Record&) {});
    journal.restore_blocks([](std::uint64_t, const Bytes&) {});
    journal.restore_looks([](RegionId, const Bytes&) {});
    journal.keep_look(RegionId{0}, {1});
    journal.commit(records);
  } catch (const BadInput&) {
    // Somebody else's, or of another version.
  } catch (const Failure&) {
    // No journal can be had here: said in one line, nothing lost.
  }
  remove_all_of(path);
  return 0;
}
