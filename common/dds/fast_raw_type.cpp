#include "common/dds/fast_raw_type.h"

#include <cstring>

namespace muster::dds {

bool FastRawType::serialize(void* sample, Payload* payload) {
  const Bytes& bytes = *static_cast<const Bytes*>(sample);
  if (payload->max_size < bytes.size()) return false;
  std::memcpy(payload->data, bytes.data(), bytes.size());
  payload->length = static_cast<std::uint32_t>(bytes.size());
  payload->encapsulation = CDR_LE;
  return true;
}

bool FastRawType::deserialize(Payload* payload, void* sample) {
  static_cast<Bytes*>(sample)->assign(payload->data, payload->data + payload->length);
  return true;
}

std::function<std::uint32_t()> FastRawType::getSerializedSizeProvider(void* sample) {
  const auto size = static_cast<std::uint32_t>(static_cast<const Bytes*>(sample)->size());
  return [size] { return size; };
}

}  // namespace muster::dds
