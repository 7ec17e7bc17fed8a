#include "common/store/shelf.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "common/core/error.h"
#include "common/store/record_store.h"

using namespace muster;
using namespace muster::store;

namespace {

constexpr RobotId kSelf{1}, kOther{2};

class Folder {
 public:
  Folder() { std::filesystem::create_directories(path_); }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("muster_shelf_test_" + std::to_string(getpid()));
};

Record record(RecordClass cls, std::uint64_t key, std::uint64_t seq, std::size_t bytes) {
  return {{{kOther, 1}, cls, key, seq, {}, {}}, Bytes(bytes, static_cast<std::uint8_t>(seq))};
}

}  // namespace

TEST_CASE("what was put on the shelf comes back, and leaves no file behind") {
  const Folder folder;
  Shelf shelf(folder.path());
  const Bytes first(5000, 1), second(1, 2), none;
  const auto a = shelf.put(first), b = shelf.put(second), c = shelf.put(none);
  REQUIRE((a && b && c));
  CHECK(shelf.get(*b) == second);
  CHECK(shelf.get(*a) == first);
  CHECK(shelf.get(*c).empty());
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("a shelf in a folder that is not there is refused") {
  CHECK_THROWS_AS(Shelf("/nowhere/at/all"), Failure);
}

TEST_CASE("a store with a shelf holds the same records, images only on disk") {
  const Folder folder;
  RecordStore plain(kSelf, 1), shelved(kSelf, 1);
  shelved.keep_on(std::make_unique<Shelf>(folder.path()));
  const std::vector<Record> records{
      record(RecordClass::kImage, 7, 1, 16'000), record(RecordClass::kInspection, 7, 1, 2'000),
      record(RecordClass::kMap, 3, 1, 2'000), record(RecordClass::kImage, 7, 2, 15'000),
      record(RecordClass::kImage, 8, 3, 20)};
  for (const Record& r : records) {
    plain.merge(r);
    shelved.merge(r);
  }
  CHECK(shelved.content_hash() == plain.content_hash());
  CHECK(shelved.size() == plain.size());
  for (const RecordClass cls : {RecordClass::kImage, RecordClass::kInspection, RecordClass::kMap}) {
    for (const Record* held : plain.all(cls)) {
      const Record* other = shelved.find(kOther, cls, held->header.key);
      REQUIRE(other);
      CHECK(shelved.whole(*other).bytes == held->bytes);
      CHECK(shelved.size_of(*other) == held->bytes.size());
    }
  }
  CHECK(shelved.find(kOther, RecordClass::kImage, 7)->bytes.empty());
  CHECK(!shelved.find(kOther, RecordClass::kMap, 3)->bytes.empty());
}
