#include <dds/dds.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <condition_variable>
#include <mutex>

#include "common/core/error.h"
#include "common/dds/convert.h"
#include "common/dds/participant.h"
#include "tests/free_domain.h"
#include "tests/unit/dds/cyclone_types.h"
#include "tests/unit/dds/samples.h"

namespace muster::dds {
namespace {

using namespace mission;
using test::Samples;

const std::uint32_t kDomain = test::free_domain();

/// What arrives at a reader, for a test to wait for.
class Inbox {
 public:
  OnMessage on_message() {
    return [this](Message&& m) {
      const std::lock_guard lock(mutex_);
      messages_.push_back(std::move(m));
      changed_.notify_all();
    };
  }
  OnMatch on_match() {
    return [this] {
      const std::lock_guard lock(mutex_);
      changed_.notify_all();
    };
  }
  template <class Condition>
  bool wait(Condition condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(20), condition);
  }
  std::vector<Message> take(std::size_t count) {
    wait([&] { return messages_.size() >= count; });
    const std::lock_guard lock(mutex_);
    return std::exchange(messages_, {});
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Message> messages_;
};

ParticipantConfig config(Vendor vendor, std::uint32_t participant, std::uint32_t domain = kDomain) {
  ParticipantConfig c;
  c.vendor = vendor;
  c.domain = domain;
  c.participant = participant;
  return c;
}

/// CDR → Cyclone's C struct → CDR, both by Cyclone with idlc's descriptor: what Cyclone makes of
/// our bytes.
Bytes through_cyclone(MessageClass cls, const Bytes& cdr) {
  const auto ours = make_participant(config(Vendor::kCyclone, 0));
  const dds_entity_t theirs = dds_create_participant(kDomain, nullptr, nullptr);
  const dds_entity_t topic =
      dds_create_topic(theirs, test::cyclone_descriptor(cls), topic_name(cls), nullptr, nullptr);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos, 1, &xcdr1);
  dds_qset_partition1(qos, "in");
  const dds_entity_t subscriber = dds_create_subscriber(theirs, qos, nullptr);
  const dds_entity_t reader = dds_create_reader(subscriber, topic, qos, nullptr);
  dds_qset_partition1(qos, "out");
  const dds_entity_t publisher = dds_create_publisher(theirs, qos, nullptr);
  const dds_entity_t writer = dds_create_writer(publisher, topic, qos, nullptr);
  dds_delete_qos(qos);

  Inbox inbox;
  const auto out = ours->writer(cls, "in", Delivery::kEvery, inbox.on_match());
  const auto back =
      ours->reader(cls, "out", Delivery::kEvery, inbox.on_message(), inbox.on_match());
  REQUIRE(inbox.wait([&] { return out->matched() == 1 && back->matched() == 1; }));
  out->write(cdr);
  void* sample[1] = {nullptr};
  dds_sample_info_t info;
  REQUIRE(dds_take(reader, sample, &info, 1, 1) == 1);  // within a process it is there at once
  REQUIRE(info.valid_data);
  REQUIRE(dds_write(writer, sample[0]) == DDS_RETCODE_OK);
  dds_return_loan(reader, sample, 1);
  const std::vector<Message> heard = inbox.take(1);
  dds_delete(theirs);
  REQUIRE(heard.size() == 1);
  return heard[0].cdr;
}

/// Cyclone states in the encapsulation how many bytes of padding follow, and does not count them;
/// we fill up with zeros.
void same_message(Bytes ours, Bytes cyclones) {
  cyclones.resize((cyclones.size() + 3) / 4 * 4);
  ours[3] = cyclones[3] = 0;
  CHECK(ours == cyclones);
}

TEMPLATE_TEST_CASE("Cyclone makes the same bytes of a message", "", Beacon, ExchangeEnd, Odometry,
                   Scan, Sightings, Battery, Inspected, OperatorRequest, Trajectory, Inspect,
                   Charge, Tick, Done, Truth) {
  Samples samples(11);
  for (int i = 0; i < 3; ++i) {
    const Message sent = encode(samples.make<TestType>());
    same_message(sent.cdr, through_cyclone(sent.cls, sent.cdr));
  }
}

TEST_CASE("Cyclone makes the same bytes of a record") {
  Samples samples(12);
  const auto check = [&](store::RecordClass cls, const auto& body) {
    const Message sent = wrap(samples.envelope({}), encode_record(samples.header(cls), body));
    same_message(sent.cdr, through_cyclone(sent.cls, sent.cdr));
  };
  for (int i = 0; i < 3; ++i) {
    check(store::RecordClass::kMap, samples.make<MapBlock>());
    check(store::RecordClass::kArea, samples.make<Area>());
    check(store::RecordClass::kInspection, samples.make<Inspection>());
    check(store::RecordClass::kPlan, samples.make<Plan>());
    check(store::RecordClass::kMeeting, samples.make<Meeting>());
    check(store::RecordClass::kStatus, samples.make<Status>());
  }
}

TEST_CASE("bytes pass between the vendors untouched") {
  const auto vendor = GENERATE(Vendor::kCyclone, Vendor::kFast);
  const auto other = GENERATE(Vendor::kCyclone, Vendor::kFast);
  const auto hub = make_participant(config(vendor, 0));
  const auto agent = make_participant(config(other, 1));
  Inbox inbox;
  const auto reader = hub->reader(MessageClass::kBeacon, "up.*", Delivery::kEvery,
                                  inbox.on_message(), inbox.on_match());
  const auto writer = agent->writer(MessageClass::kBeacon, up_partition(RobotId{1}),
                                    Delivery::kEvery, inbox.on_match());
  REQUIRE(inbox.wait([&] { return reader->matched() == 1 && writer->matched() == 1; }));
  Samples samples(13);
  std::vector<Bytes> sent;
  for (int i = 0; i < 300; ++i) sent.push_back(encode(samples.make<Beacon>()).cdr);
  for (const Bytes& cdr : sent) writer->write(cdr);
  const std::vector<Message> heard = inbox.take(sent.size());
  REQUIRE(heard.size() == sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) CHECK(heard[i].cdr == sent[i]);
}

TEST_CASE("a domain that is taken or does not exist is refused in one line") {
  const auto vendor = GENERATE(Vendor::kCyclone, Vendor::kFast);
  CHECK_THROWS_AS(make_participant(config(vendor, 0, 100)), BadInput);
  const auto hub = make_participant(config(Vendor::kFast, 0));
  CHECK_THROWS_WITH(make_participant(config(vendor, 0)),
                    Catch::Contains("DDS domain " + std::to_string(kDomain) + " is in use"));
  ParticipantConfig nowhere = config(vendor, 0, kDomain + 1);
  nowhere.network_interface = "no-such-interface";
  CHECK_THROWS_AS(make_participant(nowhere), Failure);
}

TEST_CASE("one process joins two domains in which everyone finds everyone") {
  const Vendor vendor = GENERATE(Vendor::kCyclone, Vendor::kFast);
  ParticipantConfig one = config(vendor, 121), other = config(vendor, 122, kDomain + 1);
  one.star = other.star = false;
  const auto first = make_participant(one), second = make_participant(other);
  CHECK(first);
  CHECK(second);
}

TEST_CASE("the shuffle loses nothing and keeps no order") {
  ParticipantConfig shuffled = config(Vendor::kCyclone, 0);
  shuffled.shuffle_seed = 5;
  const auto hub = make_participant(shuffled);
  const auto agent = make_participant(config(Vendor::kCyclone, 1));
  Inbox inbox;
  const auto reader = hub->reader(MessageClass::kCharge, "bus.1", Delivery::kEvery,
                                  inbox.on_message(), inbox.on_match());
  const auto writer =
      agent->writer(MessageClass::kCharge, "bus.1", Delivery::kEvery, inbox.on_match());
  REQUIRE(inbox.wait([&] { return reader->matched() == 1 && writer->matched() == 1; }));
  std::vector<std::uint64_t> order, heard;
  for (std::uint64_t n = 1; n <= 200; ++n) {
    Charge charge;
    charge.envelope.n = n;
    writer->write(encode(charge).cdr);
    order.push_back(n);
  }
  for (const Message& m : inbox.take(200)) heard.push_back(peek_envelope(m.cdr).n);
  CHECK(heard != order);
  std::sort(heard.begin(), heard.end());
  CHECK(heard == order);
}

}  // namespace
}  // namespace muster::dds
