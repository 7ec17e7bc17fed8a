#include "common/robot/guardian.h"

#include <algorithm>

namespace muster::robot {
namespace {

SimTime last_heard_anyone(const Knowledge& k) {
  SimTime last;
  for (const auto& [id, mate] : k.teammates()) last = std::max(last, mate.heard);
  return last;
}

}  // namespace

Intent go_home(const Knowledge& k, std::string reason, bool land) {
  Intent intent;
  intent.kind = land ? Intent::Kind::kLand : Intent::Kind::kGo;
  intent.goal = k.config().start;
  intent.through_unknown = true;
  intent.activity = mission::Activity::kReturning;
  if (land && k.odometry().state == mission::VehicleState::kLanded)
    intent.activity = mission::Activity::kLanded;
  intent.reason = std::move(reason);
  return intent;
}

std::optional<Intent> Guardian::overrule(const Knowledge& k) {
  using mission::RequestVerb;
  if (const mission::Status* request = k.request()) {
    if (request->request != RequestVerb::kLand) land_here_.reset();
    switch (request->request) {
      case RequestVerb::kHold: {
        Intent hold;
        hold.activity = mission::Activity::kHolding;
        hold.reason = "the operator asked to hold";
        return hold;
      }
      case RequestVerb::kReturn:
        return go_home(k, "the operator asked to return", false);
      case RequestVerb::kAbort:
        return go_home(k, "the operator aborted the mission");
      case RequestVerb::kLand: {
        if (!land_here_) land_here_ = k.position();
        Intent land;
        land.kind = Intent::Kind::kLand;
        land.goal.p = *land_here_;
        land.activity = mission::Activity::kLanding;
        land.reason = "the operator asked to land";
        return land;
      }
      case RequestVerb::kNone:
      case RequestVerb::kResume:
        break;
    }
  }
  const double reserve = k.mission().battery_reserve;
  if (k.config().vehicle.discharge_mah_per_s > 0 && k.battery().charge < reserve &&
      !k.battery().charging) {
    return go_home(k, "battery below its reserve");
  }
  if ((k.now() - last_heard_anyone(k)).s() > k.mission().lost_contact_s)
    return go_home(k, "nobody heard for too long");
  return std::nullopt;
}

}  // namespace muster::robot
