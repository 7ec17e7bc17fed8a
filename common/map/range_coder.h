#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "common/core/bytes.h"
#include "common/core/error.h"

namespace muster::map {

/// How likely a bit is 0, learnt from the bits seen so far: the mean of all at first, then of the
/// last 64 or so.
class Odds {
 public:
  std::uint32_t of_zero() const { return zero_; }  ///< in 1/65536, never 0 or 1
  void see(bool one) {
    const std::int32_t aim = one ? 0 : 65536;
    const std::int32_t at = zero_ + (aim - zero_) * 2 / (2 * seen_ + 3);
    zero_ = std::clamp(at, kLeast, 65536 - kLeast);
    seen_ += seen_ < kMemory ? 1 : 0;
  }

 private:
  static constexpr std::int32_t kLeast = 24, kMemory = 64;
  std::int32_t zero_ = 32768, seen_ = 0;
};

/// Arithmetic coding of bits, each by its own odds: what was likely costs a small part of a bit.
/// (The carry-propagating range coder of LZMA, with odds of 16 bits.)
class RangeEncoder {
 public:
  void bit(Odds& odds, bool one) {
    const std::uint32_t zero = (range_ >> 16) * odds.of_zero();
    if (one) {
      low_ += zero;
      range_ -= zero;
    } else {
      range_ = zero;
    }
    odds.see(one);
    for (; range_ < kTop; range_ <<= 8) shift();
  }
  /// Ends the code.
  Bytes finish() {
    for (int i = 0; i < 5; ++i) shift();
    return std::move(bytes_);
  }

 private:
  static constexpr std::uint32_t kTop = 1u << 24;
  void shift() {
    if (low_ < 0xFF000000u || low_ > 0xFFFFFFFFu) {
      if (!first_) bytes_.push_back(static_cast<std::uint8_t>(cache_ + (low_ >> 32)));
      first_ = false;
      for (; pending_ > 0; --pending_) {
        bytes_.push_back(static_cast<std::uint8_t>(0xFFu + (low_ >> 32)));
      }
      cache_ = static_cast<std::uint8_t>(low_ >> 24);
    } else {
      ++pending_;
    }
    low_ = low_ << 8 & 0xFFFFFFFFu;
  }

  Bytes bytes_;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFu;
  std::uint64_t pending_ = 0;
  std::uint8_t cache_ = 0;
  bool first_ = true;  // the first byte would always be 0
};

/// Reads what RangeEncoder wrote. Throws BadInput where the bytes end too early.
class RangeDecoder {
 public:
  explicit RangeDecoder(ByteView bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) shift();
  }
  bool bit(Odds& odds) {
    const std::uint32_t zero = (range_ >> 16) * odds.of_zero();
    const bool one = code_ >= zero;
    if (one) {
      code_ -= zero;
      range_ -= zero;
    } else {
      range_ = zero;
    }
    odds.see(one);
    for (; range_ < kTop; range_ <<= 8) shift();
    return one;
  }
  /// Is the code read to its last byte?
  bool at_end() const { return next_ == bytes_.size(); }

 private:
  static constexpr std::uint32_t kTop = 1u << 24;
  void shift() {
    if (next_ == bytes_.size()) throw BadInput("map block: cut short");
    code_ = code_ << 8 | bytes_[next_++];
  }

  ByteView bytes_;
  std::size_t next_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFu, code_ = 0;
};

}  // namespace muster::map
