#include <air.h>

#include "common/dds/convert.h"
#include "common/dds/wire_fields.h"

/// Records: the header is an author's signature under its body, so both travel as the author's own
/// bytes. The generated structs start with an envelope; on the author's side it is zero and cut
/// off, on the reader's side 24 zero bytes stand in for it.
namespace muster::dds {

template <class Io, class P>
void fields(const Io& io, air::RecordHeader& w, P& p) {
  io(w.epoch(), p.author.epoch);
  io(w.key(), p.key);
  io(w.seq(), p.seq);
  io(w.stamp_s(), p.stamp);
  io(w.author(), p.author.robot);
  io(w.cls(), p.cls);
  io(w.signature(), p.signature);
}

template <class Io, class P>
void fields(const Io& io, air::MapBlock& w, P& p) {
  io(w.resolution_m(), p.resolution_m);
  io(w.encoding(), p.encoding);
  io(w.blocks(), p.blocks);
}

template <class Io, class P>
void fields(const Io& io, air::Area& w, P& p) {
  io(w.position(), p.position);
  io(w.sighted_from(), p.sighted_from);
  io(w.normal(), p.normal);
  io(w.sigma_m(), p.sigma_m);
  io(w.sightings(), p.unexplained);
  io(w.region(), p.region);
  io(w.feature_type(), p.feature_type);
  io(w.skill(), p.skill);
  io(w.priority(), p.priority);
}

template <class Io, class P>
void fields(const Io& io, air::Finding& w, P& p) {
  io(w.feature(), p.feature);
  io(w.feature_type(), p.feature_type);
  io(w.position(), p.position);
}

template <class Io, class P>
void fields(const Io& io, air::Inspection& w, P& p) {
  io(w.area_author(), p.area.author);
  io(w.area_key(), p.area.key);
  io(w.area_position(), p.area_position);
  io(w.pose(), p.pose);
  io(w.done_s(), p.done);
  io(w.found(), p.found);
  io(w.findings(), p.findings);
  io(w.part(), p.part);
  io(w.parts(), p.parts);
  io(w.payload_bytes(), p.payload_bytes);
  io(w.payload(), p.payload);
}

template <class Io, class P>
void fields(const Io& io, air::PlanStep& w, P& p) {
  io(w.at(), p.at);
  io(w.action(), p.action);
  io(w.robot(), p.robot);
  io(w.area_author(), p.area.author);
  io(w.area_key(), p.area.key);
  io(w.duration_s(), p.duration_s);
}

template <class Io, class P>
void fields(const Io& io, air::Allocation& w, P& p) {
  io(w.robot(), p.robot);
  io(w.leader(), p.leader);
  io(w.region(), p.region);
  io(w.area_author(), p.area.author);
  io(w.area_key(), p.area.key);
}

template <class Io, class P>
void fields(const Io& io, air::Plan& w, P& p) {
  io(w.kind(), p.kind);
  io(w.steps(), p.steps);
  io(w.allocations(), p.allocations);
}

template <class Io, class P>
void fields(const Io& io, air::Rung& w, P& p) {
  io(w.place(), p.place);
  io(w.from_s(), p.from);
  io(w.until_s(), p.until);
}

template <class Io, class P>
void fields(const Io& io, air::Meeting& w, P& p) {
  io(w.kind(), p.kind);
  io(w.meeting(), p.meeting);
  io(w.proposer(), p.proposer);
  io(w.partner(), p.partner);
  io(w.ack_epoch(), p.ack_epoch);
  io(w.ack_seq(), p.ack_seq);
  io(w.ladder(), p.ladder);
  io(w.region(), p.region);
}

template <class Io, class P>
void fields(const Io& io, air::RegionProgress& w, P& p) {
  io(w.region(), p.region);
  io(w.state(), p.state);
  io(w.explored_m3(), p.explored_m3);
  io(w.volume_m3(), p.volume_m3);
  io(w.areas_found(), p.areas_found);
  io(w.areas_inspected(), p.areas_inspected);
  io(w.eta_s(), p.eta_s);
}

template <class Io, class P>
void fields(const Io& io, air::Status& w, P& p) {
  io(w.kind(), p.kind);
  io(w.robot(), p.robot);
  io(w.request(), p.request);
  io(w.request_n(), p.request_n);
  io(w.battery(), p.battery);
  io(w.energy_mah(), p.energy_mah);
  io(w.regions(), p.regions);
  io(w.looks(), p.looks);
  io(w.note(), p.note);
}

namespace {

template <class W, class P>
store::Record encode_record_as(mission::MessageClass cls, const store::RecordHeader& header,
                               const P& body) {
  MUSTER_CHECK(mission::message_class(header.cls) == cls && "the header names this body's class");
  W w;
  fields(ToWire{}, w.header(), header);
  fields(ToWire{}, w, body);
  Bytes bytes = serialise(w);
  bytes.erase(bytes.begin(), bytes.begin() + kEncapsulation + kEnvelope);
  return {header, std::move(bytes)};
}

template <class W, class P>
P decode_body_as(mission::MessageClass cls, const store::RecordView& record) try {
  if (mission::message_class(record.header.cls) != cls) throw BadInput("a record of another class");
  Bytes payload;
  payload.reserve(kEnvelope + record.bytes.size());
  payload.resize(kEnvelope);
  payload.insert(payload.end(), record.bytes.begin(), record.bytes.end());
  W w;
  deserialise_all(payload, w);
  P body;
  fields(FromWire{}, w, body);
  return body;
} catch (const BadInput& e) {
  refuse(cls, record.bytes.size(), e);
}

}  // namespace

#define MUSTER_RECORD(Name)                                                                   \
  template <>                                                                                 \
  store::Record encode_record(const store::RecordHeader& header, const mission::Name& body) { \
    return encode_record_as<air::Name>(mission::MessageClass::k##Name, header, body);         \
  }                                                                                           \
  template <>                                                                                 \
  mission::Name decode_body(const store::RecordView& record) {                                \
    return decode_body_as<air::Name, mission::Name>(mission::MessageClass::k##Name, record);  \
  }

MUSTER_RECORD(MapBlock)
MUSTER_RECORD(Area)
MUSTER_RECORD(Inspection)
MUSTER_RECORD(Plan)
MUSTER_RECORD(Meeting)
MUSTER_RECORD(Status)

mission::Message wrap(const mission::Envelope& envelope, const store::RecordView& record) {
  const mission::MessageClass cls = mission::message_class(record.header.cls);
  wire::Envelope w;
  fields(ToWire{}, w, envelope);
  w.cls(static_cast<std::uint32_t>(cls));
  mission::Message message{cls, serialise(w)};
  message.cdr.insert(message.cdr.end(), record.bytes.begin(), record.bytes.end());
  return message;
}

store::RecordHeader peek_header(const mission::Message& message) try {
  const mission::Envelope envelope = peek_envelope(message.cdr);
  if (!mission::is_record(envelope.cls)) throw BadInput("not a record");
  air::RecordHeader w;
  deserialise(payload_of(message.cdr).subspan(kEnvelope), w);
  store::RecordHeader header;
  fields(FromWire{}, w, header);
  if (mission::message_class(header.cls) != envelope.cls) {
    throw BadInput("envelope and header name different classes");
  }
  return header;
} catch (const BadInput& e) {
  throw BadInput("record of " + std::to_string(message.cdr.size()) + " bytes: " + e.what());
}

store::Record unwrap(const mission::Message& message) {
  store::RecordHeader header = peek_header(message);
  const ByteView bytes = payload_of(message.cdr).subspan(kEnvelope);
  return {std::move(header), Bytes(bytes.begin(), bytes.end())};
}

mission::Envelope peek_envelope(ByteView cdr) {
  wire::Envelope w;
  deserialise(payload_of(cdr).first(kEnvelope), w);
  mission::Envelope envelope;
  fields(FromWire{}, w, envelope);
  return envelope;
}

}  // namespace muster::dds
