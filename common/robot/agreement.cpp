#include "common/robot/agreement.h"

#include <algorithm>

namespace muster::robot {

mission::Rung standing_rung(const mission::StandingConfig& s, SimTime now) {
  SimTime from = SimTime{} + s.t0;
  const std::int64_t behind_us = (now - (from + s.window)).us;
  if (behind_us > 0) from = from + s.period * ((behind_us + s.period.us - 1) / s.period.us);
  return {s.place, from, from + s.window};
}

void Agreement::resume(const Knowledge& k) {
  const auto* mine = k.meeting(self_, partner_, mission::MeetingKind::kAcknowledgement);
  const auto* ack =
      mine ? mine : k.meeting(partner_, self_, mission::MeetingKind::kAcknowledgement);
  if (!ack || ack->body.ladder.empty()) return;
  number_ = ack->body.meeting.value;
  ladder_ = ack->body.ladder;
  since_ = ack->header.stamp;
  if (mine) acknowledged_ = {ack->body.ack_epoch, ack->body.ack_seq};
}

void Agreement::be_told(const Knowledge& k) {
  if (number_ != 0) return;
  const auto* ack = k.meeting(partner_, self_, mission::MeetingKind::kAcknowledgement);
  if (ack && ack->body.ack_epoch < k.epoch()) resume(k);
}

void Agreement::propose(Knowledge& k, std::vector<mission::Rung> ladder, RegionId region) {
  mission::Meeting m;
  m.kind = mission::MeetingKind::kProposal;
  m.meeting = MeetingId{number_ + 1};
  m.proposer = self_;
  m.partner = partner_;
  m.ladder = ladder;
  m.region = region;
  pending_ = Pending{number_ + 1, std::move(ladder)};
  k.publish(store::RecordClass::kMeeting, meeting_key(partner_, mission::MeetingKind::kProposal),
            m);
}

bool Agreement::update(Knowledge& k) { return pending_ ? hear_acknowledgement(k) : acknowledge(k); }

bool Agreement::hear_acknowledgement(Knowledge& k) {
  if (!k.in_contact(partner_)) {
    pending_.reset();  // an acknowledgement that comes after the contact is void
    return false;
  }
  const auto* mine = k.meeting(self_, partner_, mission::MeetingKind::kProposal);
  const auto* ack = k.meeting(partner_, self_, mission::MeetingKind::kAcknowledgement);
  if (!mine || !ack || std::pair(ack->body.ack_epoch, ack->body.ack_seq) != mine->header.version())
    return false;
  number_ = pending_->number;
  ladder_ = std::move(pending_->ladder);
  since_ = k.now();
  pending_.reset();
  return true;
}

bool Agreement::acknowledge(Knowledge& k) {
  const auto* theirs = k.meeting(partner_, self_, mission::MeetingKind::kProposal);
  if (!theirs || theirs->body.proposer != partner_ || !k.in_contact(partner_)) return false;
  if (theirs->header.version() <= acknowledged_ || theirs->body.ladder.empty()) return false;
  mission::Meeting ack = theirs->body;
  ack.kind = mission::MeetingKind::kAcknowledgement;
  std::tie(ack.ack_epoch, ack.ack_seq) = theirs->header.version();
  acknowledged_ = theirs->header.version();
  number_ = theirs->body.meeting.value;
  ladder_ = theirs->body.ladder;
  since_ = k.now();
  k.publish(store::RecordClass::kMeeting,
            meeting_key(partner_, mission::MeetingKind::kAcknowledgement), ack);
  return true;
}

void Agreement::clear() {
  ladder_.clear();
  pending_.reset();
}

mission::Rung Agreement::next(const Knowledge& k) const {
  for (const mission::Rung& rung : ladder_) {
    if (rung.until >= k.surely_past()) return rung;
  }
  const SimTime after = ladder_.empty() ? since_ : ladder_.back().until;
  return standing_rung(k.mission().standing, std::max(after, k.surely_past()));
}

int Agreement::missed(const Knowledge& k) const {
  int missed = 0;
  const SimTime past = k.surely_past();
  for (const mission::Rung& rung : ladder_) missed += rung.until < past ? 1 : 0;
  if (missed < static_cast<int>(ladder_.size())) return missed;
  // Before it was started nobody could have met it: of these nobody missed any.
  const SimTime after = std::max(ladder_.empty() ? since_ : ladder_.back().until, k.started());
  const mission::Rung first = standing_rung(k.mission().standing, after);
  if (past <= first.until) return missed;
  const mission::Rung now = standing_rung(k.mission().standing, past);
  return missed + static_cast<int>((now.from - first.from).us / k.mission().standing.period.us);
}

}  // namespace muster::robot
