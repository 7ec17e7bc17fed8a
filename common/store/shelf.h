#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "common/core/bytes.h"

namespace muster::store {

/// Bytes that are kept, but hardly ever read: on disk instead of in memory.
///
/// One file without a name in `dir`, gone with its process: it saves memory, it is no journal.
/// Written and read through the kernel's cache, so what is wanted again soon costs no disk access.
/// Not thread-safe.
class Shelf {
 public:
  struct Place {
    std::uint64_t offset = 0;
    std::size_t size = 0;
  };

  /// Throws Failure when no file can be made in `dir`.
  explicit Shelf(const std::string& dir);
  ~Shelf();
  Shelf(const Shelf&) = delete;
  Shelf& operator=(const Shelf&) = delete;

  /// nullopt: it could not be written (a full disk); nothing else on the shelf suffers.
  std::optional<Place> put(ByteView bytes);
  /// What was put there. Throws Failure when it cannot be read.
  Bytes get(const Place& place) const;

 private:
  int file_ = -1;
  std::uint64_t end_ = 0;
};

}  // namespace muster::store
