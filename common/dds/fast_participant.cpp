#include <algorithm>
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
#include <vector>

#include "common/core/error.h"
#include "common/dds/fast_config.h"
#include "common/dds/fast_greeter.h"
#include "common/dds/fast_raw_type.h"
#include "common/dds/vendors.h"

namespace muster::dds {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

constexpr std::size_t kOfOneProcess = 3;  // participants, besides the one that is made

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

/// RTPS vendor id 1.16, as in the first bytes of every GUID that Cyclone makes.
bool is_cyclone(const rtps::GuidPrefix_t& prefix) {
  return prefix.value[0] == 0x01 && prefix.value[1] == 0x10;
}

/// As radio: nobody hears itself.
bool is_own(const fast::DomainParticipant& participant, const rtps::GuidPrefix_t& prefix) {
  return prefix == participant.guid().guidPrefix;
}

class FastWriter final : public Writer,
                         private fast::DataWriterListener,
                         private FastGreeter::Client {
 public:
  FastWriter(fast::DomainParticipant* participant, FastGreeter& greeter, fast::Topic* topic,
             const std::string& partition, bool reliable, int depth, OnMatch on_match)
      : participant_(participant),
        greeter_(greeter),
        reliable_(reliable),
        on_match_(std::move(on_match)) {
    fast::PublisherQos qos = fast::PUBLISHER_QOS_DEFAULT;
    qos.partition().push_back(partition.c_str());
    publisher_ = checked(participant_->create_publisher(qos), "publisher");
    writer_ = checked(publisher_->create_datawriter(topic, fast_writer_qos(reliable, depth), this),
                      "writer");
  }
  ~FastWriter() override {
    writer()->set_listener(nullptr);
    greeter_.remove(*this);
    // The farewell travels on another port than the data and would overtake the last sample. (Best
    // effort: returns at once.)
    writer()->wait_for_acknowledgments({0, 300'000'000});
    publisher_->delete_datawriter(writer_);
    participant_->delete_publisher(publisher_);
  }

  void write(ByteView cdr) override {
    Bytes bytes(cdr.begin(), cdr.end());
    if (!writer()->write(&bytes)) {
      throw Failure("Fast DDS refuses to write " + std::to_string(cdr.size()) + " bytes to topic " +
                    writer()->get_topic()->get_name());
    }
  }
  int matched() const override { return std::min(matched_.load(), settled_.load()); }

 private:
  void on_publication_matched(fast::DataWriter* writer,
                              const fast::PublicationMatchedStatus& status) override {
    writer_ = writer;  // may come while it is being created
    const rtps::GuidPrefix_t other = prefix_of(status.last_subscription_handle);
    if (is_own(*participant_, other)) return;
    const bool ask = reliable_ && status.current_count_change > 0 && is_cyclone(other);
    if (ask) ++asked_;
    matched_ += status.current_count_change;
    if (ask) greeter_.add(*this);
    settle();
  }
  fast::DataWriter* writer() const { return writer_; }
  void settle() {
    if (answered_ != asked_) return;
    settled_ = matched_.load();
    if (on_match_) on_match_();
  }

  void greet() override {
    greeted_ = asked_.load();
    Bytes greeting = {0, 1, 0, 0};  // the CDR header
    writer()->write(&greeting);
  }
  bool heard() override {
    return writer()->wait_for_acknowledgments({0, 0}) == ReturnCode_t::RETCODE_OK;
  }
  void settled() override {
    answered_ = greeted_.load();
    settle();
  }

  fast::DomainParticipant* participant_;
  FastGreeter& greeter_;
  bool reliable_;
  OnMatch on_match_;
  std::atomic<int> matched_{0};  ///< readers that Fast knows
  std::atomic<int> settled_{0};  ///< … when the last time none was being greeted
  std::atomic<int> asked_{0}, greeted_{0}, answered_{0};
  fast::Publisher* publisher_ = nullptr;
  std::atomic<fast::DataWriter*> writer_{nullptr};
};

class FastReader final : public Reader, private fast::DataReaderListener {
 public:
  FastReader(fast::DomainParticipant* participant, fast::Topic* topic, mission::MessageClass cls,
             const std::string& partition, bool reliable, OnMessage on_message, OnMatch on_match)
      : participant_(participant),
        cls_(cls),
        on_message_(std::move(on_message)),
        on_match_(std::move(on_match)) {
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

  int matched() const override { return matched_; }

 private:
  void on_subscription_matched(fast::DataReader*,
                               const fast::SubscriptionMatchedStatus& status) override {
    if (is_own(*participant_, prefix_of(status.last_publication_handle))) return;
    matched_ += status.current_count_change;
    if (on_match_) on_match_();
  }

  // One thread at a time, or order would be lost between taking and handing over.
  void on_data_available(fast::DataReader* reader) override {
    const std::lock_guard lock(taking_);
    for (;;) {
      mission::Message message{cls_, {}};
      fast::SampleInfo info;
      if (reader->take_next_sample(&message.cdr, &info) != ReturnCode_t::RETCODE_OK) return;
      if (!info.valid_data || message.cdr.size() <= kGreetingSize) continue;
      if (is_own(*participant_, info.sample_identity.writer_guid().guidPrefix)) continue;
      on_message_(std::move(message));
    }
  }

  fast::DomainParticipant* participant_;
  mission::MessageClass cls_;
  OnMessage on_message_;
  OnMatch on_match_;
  std::atomic<int> matched_{0};
  std::mutex taking_;
  fast::Subscriber* subscriber_ = nullptr;
  fast::DataReader* reader_ = nullptr;
};

class FastParticipant final : public Participant {
 public:
  explicit FastParticipant(const ParticipantConfig& config)
      : profile_(config.profile), ports_(claim_ports(config)) {
    prepare_fast_library();
    // Fast knows a number only once per process, whatever the domain: whoever may sit anywhere
    // moves on.
    std::vector<PortClaim> taken;
    while (!open(config) && ports_ && !is_hub(config) && taken.size() < kOfOneProcess) {
      taken.push_back(std::move(*ports_));
      ports_.emplace(*claim_ports(config));
    }
    if (participant_ == nullptr) {
      throw Failure("DDS domain " + std::to_string(config.domain) +
                    ": Fast DDS cannot open participant " + std::to_string(number(config)));
    }
  }
  ~FastParticipant() override {
    for (const auto& [cls, topic] : topics_) participant_->delete_topic(topic);
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  std::unique_ptr<Writer> writer(mission::MessageClass cls, const std::string& partition,
                                 Delivery delivery, OnMatch on_match) override {
    const int depth = delivery == Delivery::kLatest ? 1 : kDeepHistory;
    return std::make_unique<FastWriter>(participant_, greeter_, topic(cls), partition,
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
  std::uint32_t number(const ParticipantConfig& config) const {
    return ports_ ? ports_->index() : config.participant;
  }
  bool open(const ParticipantConfig& config) {
    participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(
        config.domain, fast_participant_qos(config, number(config)));
    return participant_ != nullptr;
  }

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
  FastGreeter greeter_;
  std::mutex topics_mutex_;
  std::map<mission::MessageClass, fast::Topic*> topics_;
};

}  // namespace

std::unique_ptr<Participant> make_fast_participant(const ParticipantConfig& config) {
  return std::make_unique<FastParticipant>(config);
}

}  // namespace muster::dds
