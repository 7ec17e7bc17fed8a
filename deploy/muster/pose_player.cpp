#include "deploy/muster/pose_player.h"

#include <utility>

#include "common/dds/convert.h"

namespace muster::command {
namespace {

dds::ParticipantConfig participant_config(dds::Vendor vendor, std::uint32_t domain) {
  dds::ParticipantConfig config;
  config.vendor = vendor;
  config.domain = domain;
  config.star = false;
  return config;
}

}  // namespace

PosePlayer::PosePlayer(PoseLog log, dds::Vendor vendor, std::uint32_t domain)
    : log_(std::move(log)),
      participant_(dds::make_participant(participant_config(vendor, domain))),
      writer_(participant_->writer(mission::MessageClass::kTruth, dds::kSimPartition,
                                   dds::Delivery::kBestEffort)) {}

void PosePlayer::start() { start_ = Clock::now(); }

bool PosePlayer::play() {
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
  const double t_s = log_.begin_s() + elapsed_s;
  if (t_s > log_.end_s()) return false;
  const auto due = static_cast<std::uint64_t>(elapsed_s * kFrames_per_s) + 1;
  if (due <= frame_) return true;
  frame_ = due;
  mission::Truth truth;
  truth.k = frame_;
  truth.time = SimTime::from_s(t_s);
  truth.envelope = {
      .n = frame_, .src = kWorldId, .cls = mission::MessageClass::kTruth, .sent = truth.time};
  truth.robots = log_.at(t_s);
  writer_->write(dds::encode(truth).cdr);
  return true;
}

}  // namespace muster::command
