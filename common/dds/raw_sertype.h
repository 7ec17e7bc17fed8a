#pragma once

#include "common/core/bytes.h"

struct ddsi_sertype;
struct ddsi_serdata;

/// A Cyclone DDS type that is nothing but bytes: what is written is what is sent, what arrives is
/// what is read. Cyclone never looks inside, so there is no descriptor and no sample in memory;
/// convert checks every message when it is decoded.
///
/// This uses Cyclone's plug-in interface for types (sertype / serdata, made for ROS 2), which has
/// no promise across versions: written for 0.10.2.
namespace muster::dds {

/// A new type; ownership passes to dds_create_topic_sertype.
ddsi_sertype* new_raw_sertype(const char* type_name);
/// A sample of `type` (as registered with a topic), for dds_writecdr. `cdr` is copied.
ddsi_serdata* new_raw_serdata(const ddsi_sertype* type, ByteView cdr);
/// The bytes of a sample of a raw type; valid as long as `sample` is held.
ByteView bytes_of(const ddsi_serdata* sample);

}  // namespace muster::dds
