// Without clang there is no libFuzzer: every input of a corpus, as it is and changed a little in as
// many ways as told, always the same.
//
//     fuzz_cdr CORPUS [CHANGES]
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/core/hash.h"
#include "common/core/random.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace muster;

std::vector<Bytes> corpus(const std::string& dir) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(dir)) files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<Bytes> inputs;
  for (const auto& path : files) {
    std::ifstream file(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return inputs;
}

Bytes changed(const std::vector<Bytes>& inputs, Random& random) {
  Bytes bytes = inputs[random.below(inputs.size())];
  for (std::uint64_t times = 1 + random.below(6); times > 0 && !bytes.empty(); --times) {
    const auto at = static_cast<long>(random.below(bytes.size()));
    const auto byte = static_cast<std::uint8_t>(random.next());
    switch (random.below(5)) {
      case 0:
        bytes[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1u << (byte % 8));
        break;
      case 1:
        bytes[static_cast<std::size_t>(at)] = byte < 128 ? 0xFF : byte;
        break;
      case 2:
        bytes.erase(bytes.begin() + at);
        break;
      case 3:
        bytes.insert(bytes.begin() + at, byte);
        break;
      case 4:
        bytes.resize(static_cast<std::size_t>(at));
        break;
    }
  }
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "%s CORPUS [CHANGES]\n", argv[0]);
    return 2;
  }
  const std::vector<Bytes> inputs = corpus(argv[1]);
  if (inputs.empty()) {
    std::fprintf(stderr, "%s: an empty corpus\n", argv[1]);
    return 1;
  }
  for (const Bytes& input : inputs) LLVMFuzzerTestOneInput(input.data(), input.size());
  const unsigned long changes = argc > 2 ? std::stoul(argv[2]) : 0;
  Random random(1, kNoRobot, "fuzz");
  for (unsigned long i = 0; i < changes; ++i) {
    const Bytes input = changed(inputs, random);
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  std::printf("%zu inputs and %lu changed ones\n", inputs.size(), changes);
}
