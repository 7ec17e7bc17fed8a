#pragma once

#include <cstdint>
#include <tuple>

#include "common/core/bytes.h"
#include "common/core/ids.h"
#include "common/core/time.h"

namespace muster::store {

/// What a record is about. The order is the order in which a contact sends them: value first
/// (DESIGN "Records").
enum class RecordClass : std::uint32_t {
  kInspection = 1,  ///< results (part 0 of an image counts as one)
  kMeeting = 2,
  kRequest = 3,  ///< operator's requests, declarations, looks: said for good (air topic `status`)
  kPlan = 4,
  kArea = 5,
  kStatus = 6,
  kMap = 7,
  kImage = 8,  ///< the further parts of inspection payloads (air topic `inspection`)
};
inline constexpr std::uint32_t kRecordClasses = 8;

/// A robot since one start of its process. Larger epochs are newer.
struct Author {
  RobotId robot;
  std::uint64_t epoch = 0;
  auto operator<=>(const Author&) const = default;
};

/// Mirrors muster::air::RecordHeader.
struct RecordHeader {
  Author author;
  RecordClass cls{};
  std::uint64_t key = 0;
  std::uint64_t seq = 0;  ///< counts per (author, cls), from 1
  SimTime stamp;
  Bytes signature;

  /// For one (robot, cls, key) the highest version wins.
  std::pair<std::uint64_t, std::uint64_t> version() const { return {author.epoch, seq}; }
};

/// A record as its author wrote it.
struct Record {
  RecordHeader header;
  Bytes bytes;  ///< CDR of header and body, verbatim: the message from offset 24 on (after the
                ///< envelope), without encapsulation
};

/// A record to be read, wherever its bytes are. Good as long as what it looks at.
struct RecordView {
  RecordView(const Record& record) : header(record.header), bytes(record.bytes) {}
  RecordView(const RecordHeader& h, ByteView b) : header(h), bytes(b) {}

  const RecordHeader& header;
  ByteView bytes;
};

}  // namespace muster::store
