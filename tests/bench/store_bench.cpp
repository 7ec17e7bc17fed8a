// What a record costs a robot on its way in, to its journal, and out again.
//
//     build/tests/bench_store
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <filesystem>
#include <memory>

#include "common/store/exchange.h"
#include "common/store/journal.h"

namespace {

using namespace muster;
using namespace muster::store;
namespace fs = std::filesystem;

constexpr RobotId kSelf{1}, kOther{2};
constexpr std::size_t kImagePart = 16'000, kMapBlock = 220;

Record record(RecordClass cls, std::uint64_t n, std::size_t bytes) {
  return {{{kOther, 1}, cls, n, n, {}, {}}, Bytes(bytes, static_cast<std::uint8_t>(n))};
}

/// A journal in a file of its own, gone with it.
struct Kept {
  ~Kept() { fs::remove_all(dir); }
  fs::path dir = fs::temp_directory_path() / ("muster_bench_store_" + std::to_string(getpid()));
  std::unique_ptr<Journal> journal =
      std::make_unique<Journal>((dir / "1.db").string(), kSelf, Journal::Durability::kProcess);
  RecordStore store{kSelf, 1};
};

/// A tick in which ten records of a class arrive, and are on disk.
void arrive(benchmark::State& state, RecordClass cls, std::size_t bytes) {
  Kept kept;
  std::uint64_t n = 0;
  for (auto _ : state) {
    for (int i = 0; i < 10; ++i) kept.store.merge(record(cls, ++n, bytes));
    kept.journal->commit(kept.store);
  }
  state.SetItemsProcessed(state.iterations() * 10);
}
void images_arrive(benchmark::State& state) { arrive(state, RecordClass::kImage, kImagePart); }
void map_blocks_arrive(benchmark::State& state) { arrive(state, RecordClass::kMap, kMapBlock); }
BENCHMARK(images_arrive);
BENCHMARK(map_blocks_arrive);

/// Of a record that is to be sent on: where it is makes the difference.
void read(benchmark::State& state, RecordClass cls, std::size_t bytes) {
  Kept kept;
  constexpr std::uint64_t kHeld = 1000;
  for (std::uint64_t n = 1; n <= kHeld; ++n) kept.store.merge(record(cls, n, bytes));
  kept.journal->commit(kept.store);
  Bytes buffer;
  std::uint64_t n = 0;
  for (auto _ : state) {
    const Record* held = kept.store.find(kOther, cls, n++ % kHeld + 1);
    benchmark::DoNotOptimize(kept.store.read(*held, buffer).bytes.data());
  }
}
void read_image_from_journal(benchmark::State& state) {
  read(state, RecordClass::kImage, kImagePart);
}
void read_map_block(benchmark::State& state) { read(state, RecordClass::kMap, kMapBlock); }
BENCHMARK(read_image_from_journal);
BENCHMARK(read_map_block);

/// A process that starts again with 1000 image parts and 5000 map blocks.
void restart(benchmark::State& state) {
  Kept kept;
  for (std::uint64_t n = 1; n <= 5000; ++n) {
    if (n <= 1000) kept.store.merge(record(RecordClass::kImage, n, kImagePart));
    kept.store.merge(record(RecordClass::kMap, n, kMapBlock));
  }
  kept.journal->commit(kept.store);
  kept.journal.reset();
  for (auto _ : state) {
    Journal journal((kept.dir / "1.db").string(), kSelf, Journal::Durability::kProcess);
    RecordStore store(kSelf, journal.epoch() + 1);
    journal.restore(store, [](const Record&) {});
    journal.commit(store);
    if (store.size() != 6000) state.SkipWithError("not all of it came back");
  }
}
BENCHMARK(restart)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
