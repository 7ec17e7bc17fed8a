#include <atomic>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "common/core/error.h"
#include "common/dds/fast_config.h"
#include "common/dds/fast_raw_type.h"
#include "common/dds/vendors.h"

namespace muster::dds {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

template <class T>
T* checked(T* created, const char* what) {
  if (created == nullptr) throw Failure(std::string("Fast DDS cannot create a ") + what);
  return created;
}

rtps::GuidPrefix_t prefix_of(const fast::InstanceHandle_t& handle) {
  rtps::GUID_t guid;
  rtps::iHandle2GUID(guid, handle);
  return guid.guidPrefix;
}

/// Counts matches with others. As radio: nobody hears itself.
class Matches {
 public:
  Matches(const rtps::GuidPrefix_t& own, OnMatch on_match)
      : own_(own), on_match_(std::move(on_match)) {}
  void change(const fast::InstanceHandle_t& other, std::int32_t by) {
    if (is_own(prefix_of(other))) return;
    count_ += by;
    if (on_match_) on_match_();
  }
  bool is_own(const rtps::GuidPrefix_t& prefix) const { return prefix == own_; }
  int count() const { return count_; }

 private:
  rtps::GuidPrefix_t own_;
  OnMatch on_match_;
  std::atomic<int> count_{0};
};

class FastWriter final : public Writer, private fast::DataWriterListener {
 public:
  FastWriter(fast::DomainParticipant* participant, fast::Topic* topic, const std::string& partition,
             bool reliable, int depth, OnMatch on_match)
      : participant_(participant), matches_(participant->guid().guidPrefix, std::move(on_match)) {
    fast::PublisherQos qos = fast::PUBLISHER_QOS_DEFAULT;
    qos.partition().push_back(partition.c_str());
    publisher_ = checked(participant_->create_publisher(qos), "publisher");
    writer_ = checked(publisher_->create_datawriter(topic, fast_writer_qos(reliable, depth), this),
                      "writer");
  }
  ~FastWriter() override {
    writer_->set_listener(nullptr);
    // The farewell travels on another port than the data and would overtake the last sample. (Best
    // effort: returns at once.)
    writer_->wait_for_acknowledgments({0, 300'000'000});
    publisher_->delete_datawriter(writer_);
    participant_->delete_publisher(publisher_);
  }

  void write(ByteView cdr) override {
    Bytes bytes(cdr.begin(), cdr.end());
    if (!writer_->write(&bytes)) {
      throw Failure("Fast DDS refuses to write " + std::to_string(cdr.size()) + " bytes to topic " +
                    writer_->get_topic()->get_name());
    }
  }
  int matched() const override { return matches_.count(); }

 private:
  void on_publication_matched(fast::DataWriter*,
                              const fast::PublicationMatchedStatus& status) override {
    matches_.change(status.last_subscription_handle, status.current_count_change);
  }

  fast::DomainParticipant* participant_;
  Matches matches_;
  fast::Publisher* publisher_ = nullptr;
  fast::DataWriter* writer_ = nullptr;
};

class FastReader final : public Reader, private fast::DataReaderListener {
 public:
  FastReader(fast::DomainParticipant* participant, fast::Topic* topic, mission::MessageClass cls,
             const std::string& partition, bool reliable, OnMessage on_message, OnMatch on_match)
      : participant_(participant),
        cls_(cls),
        on_message_(std::move(on_message)),
        matches_(participant->guid().guidPrefix, std::move(on_match)) {
    fast::SubscriberQos qos = fast::SUBSCRIBER_QOS_DEFAULT;
    qos.partition().push_back(partition.c_str());
    subscriber_ = checked(participant_->create_subscriber(qos), "subscriber");
    // A deep history also for kLatest: keyless, all writers of a wildcard partition share one.
    reader_ = checked(
        subscriber_->create_datareader(topic, fast_reader_qos(reliable, kDeepHistory), this),
        "reader");
  }
  ~FastReader() override {
    reader_->set_listener(nullptr);
    subscriber_->delete_datareader(reader_);
    participant_->delete_subscriber(subscriber_);
  }

  int matched() const override { return matches_.count(); }

 private:
  void on_subscription_matched(fast::DataReader*,
                               const fast::SubscriptionMatchedStatus& status) override {
    matches_.change(status.last_publication_handle, status.current_count_change);
  }

  // One thread at a time, or order would be lost between taking and handing over.
  void on_data_available(fast::DataReader* reader) override {
    const std::lock_guard lock(taking_);
    for (;;) {
      mission::Message message{cls_, {}};
      fast::SampleInfo info;
      if (reader->take_next_sample(&message.cdr, &info) != ReturnCode_t::RETCODE_OK) return;
      if (!info.valid_data) continue;
      if (matches_.is_own(info.sample_identity.writer_guid().guidPrefix)) continue;
      on_message_(std::move(message));
    }
  }

  fast::DomainParticipant* participant_;
  mission::MessageClass cls_;
  OnMessage on_message_;
  Matches matches_;
  std::mutex taking_;
  fast::Subscriber* subscriber_ = nullptr;
  fast::DataReader* reader_ = nullptr;
};

class FastParticipant final : public Participant {
 public:
  explicit FastParticipant(const ParticipantConfig& config)
      : profile_(config.profile), ports_(claim_ports(config)) {
    prepare_fast_library();
    const std::uint32_t index = ports_ ? ports_->index() : config.participant;
    participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(
        config.domain, fast_participant_qos(config, index));
    if (participant_ == nullptr) {
      throw Failure("DDS domain " + std::to_string(config.domain) +
                    ": Fast DDS cannot open participant " + std::to_string(index));
    }
  }
  ~FastParticipant() override {
    for (const auto& [cls, topic] : topics_) participant_->delete_topic(topic);
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  std::unique_ptr<Writer> writer(mission::MessageClass cls, const std::string& partition,
                                 Delivery delivery, OnMatch on_match) override {
    const int depth = delivery == Delivery::kLatest ? 1 : kDeepHistory;
    return std::make_unique<FastWriter>(participant_, topic(cls), partition,
                                        is_reliable(profile_, cls, delivery), depth,
                                        std::move(on_match));
  }

  std::unique_ptr<Reader> reader(mission::MessageClass cls, const std::string& partition,
                                 Delivery delivery, OnMessage on_message,
                                 OnMatch on_match) override {
    return std::make_unique<FastReader>(participant_, topic(cls), cls, partition,
                                        is_reliable(profile_, cls, delivery), std::move(on_message),
                                        std::move(on_match));
  }

 private:
  fast::Topic* topic(mission::MessageClass cls) {
    const std::lock_guard lock(topics_mutex_);
    fast::Topic*& topic = topics_[cls];
    if (topic == nullptr) {
      const char* type_name = mission::type_name(cls);
      fast::TypeSupport(new FastRawType(type_name)).register_type(participant_);
      topic = checked(
          participant_->create_topic(mission::topic_name(cls), type_name, fast::TOPIC_QOS_DEFAULT),
          "topic");
    }
    return topic;
  }

  Profile profile_;
  std::optional<PortClaim> ports_;
  fast::DomainParticipant* participant_ = nullptr;
  std::mutex topics_mutex_;
  std::map<mission::MessageClass, fast::Topic*> topics_;
};

}  // namespace

std::unique_ptr<Participant> make_fast_participant(const ParticipantConfig& config) {
  return std::make_unique<FastParticipant>(config);
}

}  // namespace muster::dds
