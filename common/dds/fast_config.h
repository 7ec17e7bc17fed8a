#pragma once

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "common/dds/participant.h"

/// Our profiles in Fast DDS's terms.
namespace muster::dds {

/// Settings of the whole process, made once: no delivery past the sockets, and its log through
/// ours.
void prepare_fast_library();

/// `index` is the place on this machine that the ports follow from.
eprosima::fastdds::dds::DomainParticipantQos fast_participant_qos(const ParticipantConfig& config,
                                                                  std::uint32_t index);
eprosima::fastdds::dds::DataWriterQos fast_writer_qos(bool reliable, int depth);
eprosima::fastdds::dds::DataReaderQos fast_reader_qos(bool reliable, int depth);

}  // namespace muster::dds
