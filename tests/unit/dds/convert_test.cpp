#include "common/dds/convert.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>

#include "common/core/error.h"
#include "tests/unit/dds/samples.h"

namespace muster::dds {
namespace {

using namespace mission;
using test::Samples;

#define MUSTER_WHOLE_TYPES                                                                         \
  Beacon, ExchangeEnd, Odometry, Scan, Sightings, Battery, Inspected, OperatorRequest, Trajectory, \
      Inspect, Charge, Tick, Done, Truth
#define MUSTER_BODY_TYPES MapBlock, Area, Inspection, Plan, Meeting, Status

template <class T>
store::RecordClass record_class_of() {
  if constexpr (std::is_same_v<T, MapBlock>) return store::RecordClass::kMap;
  if constexpr (std::is_same_v<T, Area>) return store::RecordClass::kArea;
  if constexpr (std::is_same_v<T, Inspection>) return store::RecordClass::kImage;
  if constexpr (std::is_same_v<T, Plan>) return store::RecordClass::kPlan;
  if constexpr (std::is_same_v<T, Meeting>) return store::RecordClass::kMeeting;
  if constexpr (std::is_same_v<T, Status>) return store::RecordClass::kStatus;
  std::abort();
}

/// Freed memory, full of 0xAA, is what the next buffers are made of.
void dirty_the_heap() {
  std::vector<std::unique_ptr<Bytes>> blocks;
  for (std::size_t size = 16; size <= 65536; size += size / 4) {
    for (int i = 0; i < 8; ++i) blocks.push_back(std::make_unique<Bytes>(size, 0xAA));
  }
}

/// Flips, cuts and stretches; decoding must answer with a value or BadInput, never crash.
template <class Decode>
void survive_mutations(const Bytes& good, Decode decode) {
  Random random(1, RobotId{1}, "mutations");
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Bytes bad = good;
    for (std::uint64_t flips = random.below(4); flips > 0; --flips) {
      bad[random.below(bad.size())] = static_cast<std::uint8_t>(random.next());
    }
    if (random.chance(0.3)) bad.resize(random.below(bad.size() + 9));
    if (random.chance(0.1) && bad.size() > 40) {  // a length of 4 billion
      const std::size_t at = 28 + random.below(bad.size() - 32) / 4 * 4;
      std::fill_n(bad.begin() + static_cast<std::ptrdiff_t>(at), 4, std::uint8_t{0xFF});
    }
    try {
      decode(bad);
    } catch (const BadInput&) {
      ++refused;
    }
  }
  CHECK(refused > 300);
}

TEMPLATE_TEST_CASE("a message survives the wire and equal values are equal bytes", "",
                   MUSTER_WHOLE_TYPES) {
  Samples samples(3);
  for (int i = 0; i < 20; ++i) {
    const auto value = samples.make<TestType>();
    const Message sent = encode(value);
    dirty_the_heap();
    CHECK(encode(value).cdr == sent.cdr);
    CHECK(sent.cdr.size() % 4 == 0);
    CHECK(Bytes(sent.cdr.begin(), sent.cdr.begin() + 4) == Bytes{0, 1, 0, 0});
    const auto back = decode<TestType>(sent);
    CHECK(encode(back).cdr == sent.cdr);
    const Envelope envelope = peek_envelope(sent.cdr);
    CHECK(envelope.n == value.envelope.n);
    CHECK(envelope.src == value.envelope.src);
    CHECK(envelope.cls == sent.cls);
    CHECK(envelope.sent == value.envelope.sent);
  }
}

TEMPLATE_TEST_CASE("a record's bytes pass through any number of envelopes untouched", "",
                   MUSTER_BODY_TYPES) {
  Samples samples(4);
  for (int i = 0; i < 20; ++i) {
    const store::RecordHeader header = samples.header(record_class_of<TestType>());
    const auto body = samples.make<TestType>();
    const store::Record record = encode_record(header, body);
    dirty_the_heap();
    CHECK(encode_record(header, body).bytes == record.bytes);
    const Message first = wrap(samples.envelope({}), record);
    const store::Record heard = unwrap(first);
    CHECK(heard.bytes == record.bytes);
    CHECK(heard.header.author == header.author);
    CHECK(heard.header.cls == header.cls);
    CHECK(heard.header.key == header.key);
    CHECK(heard.header.seq == header.seq);
    CHECK(heard.header.stamp == header.stamp);
    CHECK(heard.header.signature == header.signature);
    CHECK(unwrap(wrap(samples.envelope({}), heard)).bytes == record.bytes);
    CHECK(encode_record(header, decode_body<TestType>(heard)).bytes == record.bytes);
  }
}

TEMPLATE_TEST_CASE("corrupt messages are refused, not believed", "", MUSTER_WHOLE_TYPES) {
  Samples samples(5);
  const Message good = encode(samples.make<TestType>());
  survive_mutations(good.cdr, [&](const Bytes& bad) { decode<TestType>({good.cls, bad}); });
}

TEMPLATE_TEST_CASE("corrupt records are refused, not believed", "", MUSTER_BODY_TYPES) {
  Samples samples(6);
  const store::RecordHeader header = samples.header(record_class_of<TestType>());
  const Message good = wrap(samples.envelope({}), encode_record(header, samples.make<TestType>()));
  survive_mutations(good.cdr, [&](const Bytes& bad) {
    decode_body<TestType>(unwrap({good.cls, bad}));
  });
}

TEST_CASE("what is not this message is refused with a reason") {
  Samples samples(7);
  Odometry odometry = samples.make<Odometry>();
  CHECK_THROWS_AS(decode<Scan>(encode(odometry)), BadInput);
  CHECK_THROWS_AS(unwrap(encode(odometry)), BadInput);
  CHECK_THROWS_AS(peek_envelope(Bytes{0, 1, 0, 0}), BadInput);
  odometry.pose.p.y() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(decode<Odometry>(encode(odometry)), BadInput);
  Beacon beacon = samples.make<Beacon>();
  beacon.trajectory.back().pose.p.z() = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(decode<Beacon>(encode(beacon)), BadInput);
  const store::Record area =
      encode_record(samples.header(store::RecordClass::kArea), samples.make<Area>());
  CHECK_THROWS_AS(decode_body<Plan>(area), BadInput);
}

template <class F>
double mean_us(F once) {
  constexpr int kRuns = 20000;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kRuns; ++i) once();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start)
             .count() /
         kRuns;
}

TEST_CASE("what a message costs, there and back", "[.bench]") {
  Samples samples(8);
  const auto odometry = samples.make<Odometry>();
  const auto beacon = samples.make<Beacon>();
  const auto area = samples.make<Area>();
  const auto header = samples.header(store::RecordClass::kArea);
  std::printf("odometry %.2f us\n", mean_us([&] { decode<Odometry>(encode(odometry)); }));
  std::printf("beacon %.2f us\n", mean_us([&] { decode<Beacon>(encode(beacon)); }));
  std::printf("area record %.2f us\n", mean_us([&] {
                decode_body<Area>(unwrap(wrap(Envelope{}, encode_record(header, area))));
              }));
}

}  // namespace
}  // namespace muster::dds
