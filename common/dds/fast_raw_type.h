#pragma once

#include <fastdds/dds/topic/TopicDataType.hpp>
#include <string>

#include "common/core/bytes.h"

namespace muster::dds {

/// A Fast DDS type that is nothing but bytes: a sample is a Bytes, CDR with its encapsulation. Fast
/// never looks inside; convert checks every message when it is decoded.
class FastRawType final : public eprosima::fastdds::dds::TopicDataType {
 public:
  using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;

  explicit FastRawType(const char* type_name) {
    setName(type_name);
    m_typeSize = 1024;  // a first guess; payloads grow as needed
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  bool serialize(void* sample, Payload* payload) override;
  bool deserialize(Payload* payload, void* sample) override;
  std::function<std::uint32_t()> getSerializedSizeProvider(void* sample) override;
  void* createData() override { return new Bytes; }
  void deleteData(void* sample) override { delete static_cast<Bytes*>(sample); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

}  // namespace muster::dds
