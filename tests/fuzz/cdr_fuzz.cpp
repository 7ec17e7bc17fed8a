// Every message of idl/ from bytes: the first byte says of which class it is, the rest is its CDR.
#include "common/dds/convert.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace muster;
using namespace muster::mission;

/// What could be read can be written, and reads back.
template <class T>
void whole(const Message& message) {
  fuzz::refuses_or_reads([&] { dds::decode<T>(dds::encode(dds::decode<T>(message))); });
}

template <class T>
void record(const Message& message) {
  fuzz::refuses_or_reads([&] {
    const store::Record r = dds::unwrap(message);
    dds::wrap(dds::peek_envelope(message.cdr), r);
    dds::encode_record(r.header, dds::decode_body<T>(r));
  });
}

void read(const Message& m) {
  switch (m.cls) {
    case MessageClass::kBeacon:
      return whole<Beacon>(m);
    case MessageClass::kExchangeEnd:
      return whole<ExchangeEnd>(m);
    case MessageClass::kMapBlock:
      return record<MapBlock>(m);
    case MessageClass::kArea:
      return record<Area>(m);
    case MessageClass::kInspection:
      return record<Inspection>(m);
    case MessageClass::kPlan:
      return record<Plan>(m);
    case MessageClass::kMeeting:
      return record<Meeting>(m);
    case MessageClass::kStatus:
      return record<Status>(m);
    case MessageClass::kOdometry:
      return whole<Odometry>(m);
    case MessageClass::kScan:
      return whole<Scan>(m);
    case MessageClass::kSightings:
      return whole<Sightings>(m);
    case MessageClass::kBattery:
      return whole<Battery>(m);
    case MessageClass::kInspected:
      return whole<Inspected>(m);
    case MessageClass::kOperatorRequest:
      return whole<OperatorRequest>(m);
    case MessageClass::kTrajectory:
      return whole<Trajectory>(m);
    case MessageClass::kInspect:
      return whole<Inspect>(m);
    case MessageClass::kCharge:
      return whole<Charge>(m);
    case MessageClass::kTick:
      return whole<Tick>(m);
    case MessageClass::kDone:
      return whole<Done>(m);
    case MessageClass::kTruth:
      return whole<Truth>(m);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Message message{static_cast<MessageClass>(data[0]), Bytes(data + 1, data + size)};
  fuzz::refuses_or_reads([&] { dds::peek_envelope(message.cdr); });
  read(message);
  return 0;
}
