#pragma once

#include <type_traits>

#include "common/mission/messages.h"

/// Plain structs ↔ CDR (XCDR1 little endian, 4 bytes of encapsulation). The one place that knows
/// both sides; Fast CDR and the generated types stay in convert.cpp. Equal values give equal bytes:
/// buffers are zeroed before writing.
namespace muster::dds {

template <class T>
concept WholeMessage = requires(T m) {
  m.envelope;
};  // Beacon, ExchangeEnd, and all of bus and sim
template <class T>
concept RecordBody = std::is_same_v<T, mission::MapBlock> || std::is_same_v<T, mission::Area> ||
    std::is_same_v<T, mission::Inspection> || std::is_same_v<T, mission::Plan> ||
    std::is_same_v<T, mission::Meeting> || std::is_same_v<T, mission::Status>;

/// The message as it travels. `envelope.cls` is set to the type's own class.
template <WholeMessage T>
mission::Message encode(const T& message);
/// Throws BadInput when the bytes are not a T (too short, lengths beyond the end, class of another
/// type, non-finite numbers where a position or time is due).
template <WholeMessage T>
T decode(const mission::Message& message);

/// Author's side: header and body become a record.
template <RecordBody T>
store::Record encode_record(const store::RecordHeader& header, const T& body);
/// The body, from the author's bytes.
template <RecordBody T>
T decode_body(const store::RecordView& record);

/// A record under a fresh envelope, its bytes untouched; and back.
mission::Message wrap(const mission::Envelope& envelope, const store::RecordView& record);
store::Record unwrap(const mission::Message& message);
/// Only whose record it is and which; the body is not looked at. Throws BadInput.
store::RecordHeader peek_header(const mission::Message& message);

/// The first 24 bytes after the encapsulation, without decoding anything else.
mission::Envelope peek_envelope(ByteView cdr);

}  // namespace muster::dds
