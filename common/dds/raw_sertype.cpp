#include "common/dds/raw_sertype.h"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_keyhash.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <new>

namespace muster::dds {
namespace {

struct RawSerdata : ddsi_serdata {
  Bytes bytes;
};

RawSerdata* raw(ddsi_serdata* d) { return static_cast<RawSerdata*>(d); }
const RawSerdata* raw(const ddsi_serdata* d) { return static_cast<const RawSerdata*>(d); }

// Cyclone stores sizes as given but asks for bytes in multiples of 4: the tail is zero.
RawSerdata* make(const ddsi_sertype* type, ddsi_serdata_kind kind, std::size_t size) {
  auto* d = new RawSerdata{};
  ddsi_serdata_init(d, type, kind);
  d->bytes.reserve((size + 3) / 4 * 4);
  return d;
}

// Keyless: there is one instance, and all keys are equal.
bool eqkey(const ddsi_serdata*, const ddsi_serdata*) { return true; }
ddsi_serdata* to_untyped(const ddsi_serdata* d) {
  RawSerdata* key = make(d->type, SDK_KEY, 0);
  key->type = nullptr;
  return key;
}
ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash*) {
  return make(type, SDK_KEY, 0);
}
void get_keyhash(const ddsi_serdata*, ddsi_keyhash* hash, bool) {
  std::memset(hash->value, 0, sizeof hash->value);
}

std::uint32_t get_size(const ddsi_serdata* d) {
  return static_cast<std::uint32_t>(raw(d)->bytes.size());
}

// Fragments come in order and may overlap.
ddsi_serdata* from_ser(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                       std::size_t size) {
  RawSerdata* d = make(type, kind, size);
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    const std::size_t have = d->bytes.size();
    const std::size_t end = std::min<std::size_t>(fragment->maxp1, size);
    if (end <= have) continue;
    const unsigned char* payload =
        NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    const unsigned char* from = payload + (have - fragment->min);
    d->bytes.insert(d->bytes.end(), from, from + (end - have));
  }
  return d;
}

ddsi_serdata* from_ser_iov(const ddsi_sertype* type, ddsi_serdata_kind kind,
                           ddsrt_msg_iovlen_t count, const ddsrt_iovec_t* iov, std::size_t size) {
  RawSerdata* d = make(type, kind, size);
  for (ddsrt_msg_iovlen_t i = 0; i < count && d->bytes.size() < size; ++i) {
    const auto* from = static_cast<const std::uint8_t*>(iov[i].iov_base);
    d->bytes.insert(d->bytes.end(), from,
                    from + std::min<std::size_t>(iov[i].iov_len, size - d->bytes.size()));
  }
  return d;
}

void to_ser(const ddsi_serdata* d, std::size_t offset, std::size_t size, void* buffer) {
  const Bytes& bytes = raw(d)->bytes;
  const std::size_t have = offset < bytes.size() ? std::min(size, bytes.size() - offset) : 0;
  std::memset(buffer, 0, size);
  if (have > 0) std::memcpy(buffer, bytes.data() + offset, have);
}

ddsi_serdata* to_ser_ref(const ddsi_serdata* d, std::size_t offset, std::size_t size,
                         ddsrt_iovec_t* ref) {
  // `size` may reach into the padding; `make` reserved and new_raw_serdata zeroed it.
  ref->iov_base = const_cast<std::uint8_t*>(raw(d)->bytes.data() + offset);
  ref->iov_len = size;
  return ddsi_serdata_ref(d);
}
void to_ser_unref(ddsi_serdata* d, const ddsrt_iovec_t*) { ddsi_serdata_unref(d); }

// Nobody reads or writes typed samples of a raw type.
ddsi_serdata* from_sample(const ddsi_sertype*, ddsi_serdata_kind, const void*) { return nullptr; }
bool to_sample(const ddsi_serdata*, void*, void**, void*) { return false; }
bool untyped_to_sample(const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) {
  return false;
}

std::size_t print(const ddsi_sertype*, const ddsi_serdata* d, char* buffer, std::size_t size) {
  return static_cast<std::size_t>(
      std::snprintf(buffer, size, "%zu bytes of CDR", raw(d)->bytes.size()));
}

void free_serdata(ddsi_serdata* d) { delete raw(d); }

ddsi_serdata_ops serdata_ops() {
  ddsi_serdata_ops ops{};
  ops.eqkey = eqkey;
  ops.get_size = get_size;
  ops.from_ser = from_ser;
  ops.from_ser_iov = from_ser_iov;
  ops.from_keyhash = from_keyhash;
  ops.from_sample = from_sample;
  ops.to_ser = to_ser;
  ops.to_ser_ref = to_ser_ref;
  ops.to_ser_unref = to_ser_unref;
  ops.to_sample = to_sample;
  ops.to_untyped = to_untyped;
  ops.untyped_to_sample = untyped_to_sample;
  ops.free = free_serdata;
  ops.print = print;
  ops.get_keyhash = get_keyhash;
  return ops;
}

// Two raw types with one name are the same type.
bool equal(const ddsi_sertype*, const ddsi_sertype*) { return true; }
std::uint32_t hash(const ddsi_sertype*) { return 0; }
void free_sertype(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete type;
}

ddsi_sertype_ops sertype_ops() {
  ddsi_sertype_ops ops{};
  ops.version = ddsi_sertype_v0;
  ops.free = free_sertype;
  ops.equal = equal;
  ops.hash = hash;
  return ops;
}

}  // namespace

ddsi_sertype* new_raw_sertype(const char* type_name) {
  static const ddsi_sertype_ops kTypeOps = sertype_ops();
  static const ddsi_serdata_ops kDataOps = serdata_ops();
  auto* type = new ddsi_sertype{};
  ddsi_sertype_init(type, type_name, &kTypeOps, &kDataOps, /* topickind_no_key = */ true);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

ddsi_serdata* new_raw_serdata(const ddsi_sertype* type, ByteView cdr) {
  RawSerdata* d = make(type, SDK_DATA, cdr.size());
  d->bytes.assign(cdr.begin(), cdr.end());
  d->bytes.resize((cdr.size() + 3) / 4 * 4);
  return d;
}

ByteView bytes_of(const ddsi_serdata* sample) { return raw(sample)->bytes; }

}  // namespace muster::dds
