#include "common/robot/guardian.h"

#include <algorithm>
#include <utility>

namespace muster::robot {
namespace {

SimTime last_heard_anyone(const Knowledge& k) {
  SimTime last;
  for (const auto& [id, mate] : k.teammates()) last = std::max(last, mate.heard);
  return last;
}

constexpr double kLongestTurn_s = 30, kRound_s = 300;

/// Silent robots go home one after the other. Two that fly the same speed on courses less than 90°
/// apart are never in each other's camera, and all that lost each other at once would set out at
/// once, for the same place.
bool my_turn(const Knowledge& k) {
  const auto& fleet = k.mission().fleet;
  const auto count = static_cast<double>(fleet.size());
  const double turn_s = std::min(kLongestTurn_s, kRound_s / count);
  const auto rank = std::count_if(fleet.begin(), fleet.end(), [&](const auto& r) {
    return std::pair(r.role, r.id) < std::pair(k.config().role, k.self());
  });
  return static_cast<std::int64_t>(k.now().s() / turn_s) %
             static_cast<std::int64_t>(fleet.size()) ==
         rank;
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
  if ((k.now() - last_heard_anyone(k)).s() <= k.mission().lost_contact_s) {
    going_silently_ = false;
    return std::nullopt;
  }
  going_silently_ = going_silently_ || my_turn(k);
  if (going_silently_) return go_home(k, "nobody heard for too long");
  Intent wait;
  wait.activity = mission::Activity::kWaiting;
  wait.reason = "nobody heard for too long: waiting for its turn to go home";
  return wait;
}

}  // namespace muster::robot
