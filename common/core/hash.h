#pragma once

#include <cstdint>
#include <string_view>
#include <type_traits>

#include "common/core/bytes.h"

namespace muster {

/// 64-bit xxHash (XXH3) of bytes; the same on every machine.
std::uint64_t hash_bytes(ByteView bytes, std::uint64_t seed = 0);
std::uint64_t hash_text(std::string_view text, std::uint64_t seed = 0);

/// Folds values into one number, in the order given. Used for the trace, so only feed it what is
/// deterministic.
class Hasher {
 public:
  explicit Hasher(std::uint64_t seed = 0) : value_(seed) {}

  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T> Hasher& add(T v) {
    return add_bytes({reinterpret_cast<const std::uint8_t*>(&v), sizeof v});
  }
  Hasher& add_bytes(ByteView bytes) {
    value_ = hash_bytes(bytes, value_);
    return *this;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_;
};

}  // namespace muster
