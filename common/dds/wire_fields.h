#pragma once

#include <base.h>
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>

#include <cmath>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/core/error.h"
#include "common/mission/messages.h"

/// Inside of convert: how a plain struct and its generated twin correspond.
///
/// One function per pair lists the fields once, `fields(io, wire, plain)`, and serves both ways:
/// with `ToWire` it fills the generated struct from the plain one, with `FromWire` the other way
/// round, checking. Only convert_*.cpp may include this header.
namespace muster::dds {

template <class Plain>
inline constexpr bool kIsId = false;
template <class T, class Rep>
inline constexpr bool kIsId<Id<T, Rep>> = true;

template <class T>
concept Number = std::is_arithmetic_v<T>;

/// Plain → generated. The plain side is const.
struct ToWire {
  template <Number W, class P>
  void operator()(W& w, const P& p) const {
    if constexpr (std::is_same_v<P, SimTime>) {
      w = p.s();
    } else if constexpr (kIsId<P>) {
      static_assert(sizeof(W) == sizeof(p.value));
      w = p.value;
    } else if constexpr (std::is_enum_v<P>) {
      static_assert(sizeof(W) == sizeof(P));
      w = static_cast<W>(p);
    } else {
      if constexpr (std::is_integral_v<P>) MUSTER_CHECK(std::in_range<W>(p) && "fits its field");
      w = static_cast<W>(p);
    }
  }
  void operator()(bool& w, const bool& p) const { w = p; }
  void operator()(std::string& w, const std::string& p) const { w = p; }
  template <class W, class P>
  void operator()(std::vector<W>& w, const std::vector<P>& p) const {
    if constexpr (Number<P>) {
      w = p;
    } else {
      w.resize(p.size());
      for (std::size_t i = 0; i < p.size(); ++i) (*this)(w[i], p[i]);
    }
  }
  template <class W, class P>
  requires std::is_class_v<W>
  void operator()(W& w, const P& p) const { fields(*this, w, p); }
};

/// Generated → plain. Throws BadInput for numbers no peer of ours sends: doubles (positions, times,
/// angles) must be finite, floats must not be NaN, times must fit, a record class must exist. Other
/// enums are passed on as they are, for newer senders.
struct FromWire {
  template <Number W, class P>
  void operator()(const W& w, P& p) const {
    if constexpr (std::is_floating_point_v<W>) check(w);
    if constexpr (std::is_same_v<P, SimTime>) {
      if (std::abs(w) > kLongest_s) throw BadInput("a time beyond all missions");
      p = SimTime::from_s(w);
    } else if constexpr (kIsId<P>) {
      p = P(w);
    } else {
      p = static_cast<P>(w);
    }
    if constexpr (std::is_same_v<P, store::RecordClass>) {
      if (w < 1 || w > store::kRecordClasses) throw BadInput("a record class that does not exist");
    }
  }
  void operator()(const bool& w, bool& p) const { p = w; }
  void operator()(std::string& w, std::string& p) const { p = std::move(w); }
  template <class W, class P>
  void operator()(std::vector<W>& w, std::vector<P>& p) const {
    if constexpr (Number<P>) {
      p = std::move(w);
    } else {
      p.resize(w.size());
      for (std::size_t i = 0; i < w.size(); ++i) (*this)(w[i], p[i]);
    }
  }
  template <class W, class P>
  requires std::is_class_v<W>
  void operator()(W& w, P& p) const { fields(*this, w, p); }

 private:
  static constexpr double kLongest_s = 1e12;
  static void check(double w) {
    if (!std::isfinite(w)) throw BadInput("a number that is not finite");
  }
  static void check(float w) {
    if (std::isnan(w)) throw BadInput("not a number");
  }
};

// `P` below is the plain type, const on the way to the wire.
template <class Io, class P>
void fields(const Io& io, wire::Envelope& w, P& p) {
  io(w.n(), p.n);
  io(w.src(), p.src);
  io(w.cls(), p.cls);
  io(w.sent_s(), p.sent);
}
template <class Io, class P>
void fields(const Io& io, wire::Vec3& w, P& p) {
  io(w.x(), p.x());
  io(w.y(), p.y());
  io(w.z(), p.z());
}
template <class Io, class P>
void fields(const Io& io, wire::Pose& w, P& p) {
  io(w.p(), p.p);
  io(w.yaw_rad(), p.yaw_rad);
}
template <class Io, class P>
void fields(const Io& io, wire::TimedPose& w, P& p) {
  io(w.t_s(), p.t);
  io(w.x(), p.pose.p.x());
  io(w.y(), p.pose.p.y());
  io(w.z(), p.pose.p.z());
  io(w.yaw_rad(), p.pose.yaw_rad);
  if constexpr (std::is_same_v<Io, FromWire>) {
    // Floats may be infinite elsewhere ("never"), a pose may not.
    if (!p.pose.p.allFinite() || !std::isfinite(p.pose.yaw_rad)) {
      throw BadInput("a pose that is not finite");
    }
  }
}

inline constexpr std::size_t kEncapsulation = 4;
inline constexpr std::size_t kEnvelope = 24;

/// CDR with encapsulation. Zeroed before writing, because Fast CDR leaves padding as it finds it,
/// and filled up to a multiple of 4 with zeros, as RTPS does anyway: so what arrives has the length
/// of what was sent, on either vendor.
template <class W>
Bytes serialise(const W& w) {
  const std::size_t size = (W::getCdrSerializedSize(w, 0) + 3) / 4 * 4;
  Bytes out(kEncapsulation + size);
  out[1] = 1;  // CDR, little endian
  eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(out.data() + kEncapsulation), size);
  eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS,
                             eprosima::fastcdr::Cdr::DDS_CDR);
  w.serialize(cdr);
  return out;
}

/// Reads one W from `payload` (no encapsulation; starts at an offset that is a multiple of 8 in its
/// message).
template <class W>
std::size_t deserialise(ByteView payload, W& w) {
  // Fast CDR reads only, but takes a char*.
  auto* data = const_cast<char*>(reinterpret_cast<const char*>(payload.data()));
  eprosima::fastcdr::FastBuffer buffer(data, payload.size());
  eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS,
                             eprosima::fastcdr::Cdr::DDS_CDR);
  try {
    w.deserialize(cdr);
  } catch (const eprosima::fastcdr::exception::Exception&) {
    throw BadInput("cut short or corrupt");
  }
  return cdr.getSerializedDataLength();
}

/// As `deserialise`, and nothing but padding may follow.
template <class W>
void deserialise_all(ByteView payload, W& w) {
  if (deserialise(payload, w) + 3 < payload.size()) throw BadInput("bytes left over");
}

/// The payload of a message, or BadInput.
inline ByteView payload_of(ByteView cdr) {
  if (cdr.size() < kEncapsulation + kEnvelope) throw BadInput("shorter than an envelope");
  if (cdr[0] != 0 || cdr[1] != 1) throw BadInput("not little-endian CDR");
  return cdr.subspan(kEncapsulation);
}

[[noreturn]] inline void refuse(mission::MessageClass cls, std::size_t size, const BadInput& why) {
  throw BadInput(std::string(mission::topic_name(cls)) + " of " + std::to_string(size) +
                 " bytes: " + why.what());
}

template <class W, class P>
mission::Message encode_as(mission::MessageClass cls, const P& plain) {
  W w;
  fields(ToWire{}, w, plain);
  w.envelope().cls(static_cast<std::uint32_t>(cls));
  return {cls, serialise(w)};
}

template <class W, class P>
P decode_as(mission::MessageClass cls, const mission::Message& message) try {
  W w;
  deserialise_all(payload_of(message.cdr), w);
  P plain;
  fields(FromWire{}, w, plain);
  if (plain.envelope.cls != cls) throw BadInput("its envelope names another class");
  return plain;
} catch (const BadInput& e) {
  refuse(cls, message.cdr.size(), e);
}

}  // namespace muster::dds

/// encode and decode of one message that is no record: mission::Name ↔ muster::module::Name.
#define MUSTER_WHOLE(module, Name)                                                          \
  template <>                                                                               \
  mission::Message encode(const mission::Name& message) {                                   \
    return encode_as<module::Name>(mission::MessageClass::k##Name, message);                \
  }                                                                                         \
  template <>                                                                               \
  mission::Name decode(const mission::Message& message) {                                   \
    return decode_as<module::Name, mission::Name>(mission::MessageClass::k##Name, message); \
  }
