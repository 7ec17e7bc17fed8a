#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

#include <array>
#include <atomic>
#include <map>
#include <mutex>
#include <utility>

#include "common/core/error.h"
#include "common/dds/cyclone_domain.h"
#include "common/dds/raw_sertype.h"
#include "common/dds/vendors.h"

namespace muster::dds {
namespace {

using QosPtr = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;
using ListenerPtr = std::unique_ptr<dds_listener_t, decltype(&dds_delete_listener)>;

dds_entity_t checked(dds_entity_t result, const std::string& what) {
  if (result < 0) throw Failure("Cyclone DDS: " + what + ": " + dds_strretcode(result));
  return result;
}

/// An entity and what is below it, deleted at the end. Deleting waits for running callbacks.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t handle) : handle_(handle) {}
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Entity() {
    if (handle_ > 0) dds_delete(handle_);
  }
  dds_entity_t get() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

QosPtr group_qos(const std::string& partition) {
  QosPtr qos(dds_create_qos(), dds_delete_qos);
  dds_qset_partition1(qos.get(), partition.c_str());
  return qos;
}

QosPtr endpoint_qos(bool reliable, int depth) {
  QosPtr qos(dds_create_qos(), dds_delete_qos);
  dds_qset_reliability(qos.get(), reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  // As radio: nobody hears itself.
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &xcdr1);
  return qos;
}

struct Topic {
  Entity entity;
  const ddsi_sertype* type = nullptr;
};

class CycloneWriter final : public Writer {
 public:
  CycloneWriter(dds_entity_t participant, const Topic& topic, const std::string& partition,
                bool reliable, int depth, OnMatch on_match)
      : type_(topic.type), on_match_(std::move(on_match)) {
    publisher_ = Entity(checked(
        dds_create_publisher(participant, group_qos(partition).get(), nullptr), "publisher"));
    const ListenerPtr listener(dds_create_listener(this), dds_delete_listener);
    dds_lset_publication_matched(listener.get(), [](dds_entity_t, auto status, void* self) {
      static_cast<CycloneWriter*>(self)->match(static_cast<int>(status.current_count));
    });
    writer_ = checked(dds_create_writer(publisher_.get(), topic.entity.get(),
                                        endpoint_qos(reliable, depth).get(), listener.get()),
                      "writer");
  }

  void write(ByteView cdr) override {
    checked(dds_writecdr(writer_, new_raw_serdata(type_, cdr)), "write");
  }
  int matched() const override { return matched_; }

 private:
  void match(int count) {
    matched_ = count;
    if (on_match_) on_match_();
  }

  const ddsi_sertype* type_;
  OnMatch on_match_;
  std::atomic<int> matched_{0};
  Entity publisher_;  // last: gone before what its callbacks use
  dds_entity_t writer_ = 0;
};

class CycloneReader final : public Reader {
 public:
  CycloneReader(dds_entity_t participant, const Topic& topic, mission::MessageClass cls,
                const std::string& partition, bool reliable, OnMessage on_message, OnMatch on_match)
      : cls_(cls), on_message_(std::move(on_message)), on_match_(std::move(on_match)) {
    subscriber_ = Entity(checked(
        dds_create_subscriber(participant, group_qos(partition).get(), nullptr), "subscriber"));
    const ListenerPtr listener(dds_create_listener(this), dds_delete_listener);
    dds_lset_subscription_matched(listener.get(), [](dds_entity_t, auto status, void* self) {
      static_cast<CycloneReader*>(self)->match(static_cast<int>(status.current_count));
    });
    dds_lset_data_available(listener.get(), [](dds_entity_t reader, void* self) {
      static_cast<CycloneReader*>(self)->take(reader);
    });
    // A deep history also for kLatest: keyless, all writers of a wildcard partition share one.
    checked(dds_create_reader(subscriber_.get(), topic.entity.get(),
                              endpoint_qos(reliable, kDeepHistory).get(), listener.get()),
            "reader");
  }

  int matched() const override { return matched_; }

 private:
  void match(int count) {
    matched_ = count;
    if (on_match_) on_match_();
  }

  // Called by the receive thread and, for writers of this process, by theirs: one at a time, or
  // order would be lost between taking and handing over.
  void take(dds_entity_t reader) {
    const std::lock_guard lock(taking_);
    std::array<ddsi_serdata*, 16> samples{};
    std::array<dds_sample_info_t, 16> infos{};
    for (;;) {
      const dds_return_t n =
          dds_takecdr(reader, samples.data(), samples.size(), infos.data(), DDS_ANY_STATE);
      for (std::size_t i = 0; n > 0 && i < static_cast<std::size_t>(n); ++i) {
        if (infos[i].valid_data) hand_over(samples[i]);
        ddsi_serdata_unref(samples[i]);
      }
      if (n < static_cast<dds_return_t>(samples.size())) return;
    }
  }

  void hand_over(const ddsi_serdata* sample) {
    const ByteView bytes = bytes_of(sample);
    if (bytes.size() <= kGreetingSize) return;  // a Fast writer says hello
    on_message_({cls_, Bytes(bytes.begin(), bytes.end())});
  }

  mission::MessageClass cls_;
  OnMessage on_message_;
  OnMatch on_match_;
  std::mutex taking_;
  std::atomic<int> matched_{0};
  Entity subscriber_;  // last: gone before what its callbacks use
};

class CycloneParticipant final : public Participant {
 public:
  explicit CycloneParticipant(const ParticipantConfig& config)
      : profile_(config.profile),
        domain_(config),
        participant_(
            checked(dds_create_participant(config.domain, nullptr, nullptr), "participant")) {}

  std::unique_ptr<Writer> writer(mission::MessageClass cls, const std::string& partition,
                                 Delivery delivery, OnMatch on_match) override {
    const int depth = delivery == Delivery::kLatest ? 1 : kDeepHistory;
    return std::make_unique<CycloneWriter>(participant_.get(), topic(cls), partition,
                                           is_reliable(profile_, cls, delivery), depth,
                                           std::move(on_match));
  }

  std::unique_ptr<Reader> reader(mission::MessageClass cls, const std::string& partition,
                                 Delivery delivery, OnMessage on_message,
                                 OnMatch on_match) override {
    return std::make_unique<CycloneReader>(participant_.get(), topic(cls), cls, partition,
                                           is_reliable(profile_, cls, delivery),
                                           std::move(on_message), std::move(on_match));
  }

 private:
  const Topic& topic(mission::MessageClass cls) {
    const std::lock_guard lock(topics_mutex_);
    Topic& topic = topics_[cls];
    if (topic.entity.get() == 0) {
      ddsi_sertype* type = new_raw_sertype(mission::type_name(cls));
      topic.entity =
          Entity(checked(dds_create_topic_sertype(participant_.get(), mission::topic_name(cls),
                                                  &type, nullptr, nullptr, nullptr),
                         "topic"));
      topic.type = type;
    }
    return topic;
  }

  Profile profile_;
  CycloneDomain domain_;
  Entity participant_;
  std::mutex topics_mutex_;
  std::map<mission::MessageClass, Topic> topics_;
};

}  // namespace

std::unique_ptr<Participant> make_cyclone_participant(const ParticipantConfig& config) {
  return std::make_unique<CycloneParticipant>(config);
}

}  // namespace muster::dds
