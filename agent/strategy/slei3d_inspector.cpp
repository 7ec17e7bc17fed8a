#include "agent/strategy/slei3d_inspector.h"

#include <algorithm>

#include "agent/strategy/look_log.h"
#include "common/core/log.h"
#include "common/radio/pace.h"
#include "common/robot/guardian.h"
#include "common/robot/knowledge.h"
#include "common/robot/stopwatch.h"

namespace muster::agent {
namespace {

constexpr double kBlockedPose_s = 4;
// Refusals where no feature is known say that one is there that shows itself from somewhere else:
// after so many everything is tried once more, from the beginning.
constexpr std::size_t kManyLooks = 60;
constexpr int kMaxTries = 30;  // to find a pose at all
constexpr int kRounds = 2;     // more of these, once it was refused
constexpr double kRetryUnexplored_s = 60;
// Of a refusal: a body in the way, or a surface that lies otherwise than it seems.
constexpr double kMisled = 0.2;
constexpr double kRuledOut = 0.03;  // chance of a feature left: less is none
constexpr double kSameSpot_m = 0.3;
constexpr int kStrayLooks = 5, kManyStrayLooks = 24;
// Of some 1600 areas in eleven flights the last that was found was found at the 16th attempt.
constexpr int kHopelessLooks = 60;
constexpr std::uint32_t kSureSightings = 4;  // that no finding explains: something is there
constexpr double kDoubted = 0.5, kHopeless = 0.1;
constexpr double kAnswer_s = 0.6;  // after the hold
constexpr int kLooksInARow = 3;
constexpr double kRetryArea_s = 12;  // the map grows meanwhile
constexpr double kMoved_m = 0.4, kStuck_s = 10;
constexpr double kRouteAgain_s = 4;  // while the explorer listens
constexpr double kDetour = 1.3;
constexpr std::size_t kImagePart_bytes = 15'000;  // or what a slow radio carries in one piece
constexpr std::size_t kAroundImage_bytes = 250;   // what a record says besides

}  // namespace

Vec3 gathering_place(const mission::Mission& mission, RegionId region, RobotId inspector) {
  const Box& box = mission.boxes[region.value];
  const auto corners = box.corners();
  const Vec3 home = mission.standing.place;
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if ((corners[i] - home).norm() < (corners[best] - home).norm()) best = i;
  }
  // In a row along the edge of the box that leaves the corner.
  const Vec3 along = (corners[(best + 1) % 4] - corners[best]).normalized();
  const Vec3 inward = (corners[(best + 3) % 4] - corners[best]).normalized();
  std::uint32_t place = 0;
  for (const RobotId id : mission.with_role(mission::Role::kInspector))
    place += id < inspector ? 1 : 0;
  Vec3 p = corners[best] + 0.6 * inward + (1.0 + 1.4 * (place % 5)) * along;
  p.z() = std::max(1.0, mission.hull.low().z() + 1.0) + 1.2 * ((place / 5) % 3);
  return p;
}

Slei3dInspector::Orders Slei3dInspector::orders(const robot::Knowledge& k) const {
  Orders o;
  for (const RobotId station : k.mission().with_role(mission::Role::kStation)) {
    const auto* assignment = k.plan(station, mission::PlanKind::kAssignment);
    if (!assignment) continue;
    for (const mission::Allocation& a : assignment->body.allocations) {
      if (a.robot == k.self())
        o.leader = a.leader, o.region = a.region, o.released = a.leader == kNoRobot;
    }
  }
  if (o.leader == kNoRobot) return o;
  const auto* allocation = k.plan(o.leader, mission::PlanKind::kAllocation);
  if (!allocation) return o;
  for (const mission::Allocation& a : allocation->body.allocations) {
    if (a.robot != k.self()) continue;
    if (a.area.author == kNoRobot) {
      o.region = a.region;
      o.released = a.region == kNoRegion;
    } else if (!k.inspected(a.area) && k.areas().contains(a.area)) {
      o.areas.push_back(a.area);
    }
  }
  return o;
}

robot::Intent Slei3dInspector::decide(robot::Knowledge& k, const robot::Progress& progress) {
  if (current_ && progress.inspected) {
    log::debug("inspected {}.{}: outcome {}", current_->author.value, current_->key,
               static_cast<int>(progress.inspected->outcome));
    report(k, *progress.inspected);
  }
  const Orders o = orders(k);
  if (o.region != routed_region_) {
    worked_ = false;
    end_.reset();
  }
  if (k.declared_complete()) return robot::go_home(k, "the mission is complete");
  if (!o.areas.empty()) {
    robot::Intent intent = inspect(k, o, progress);
    publish_route(k, o);
    return intent;
  }
  current_.reset();
  publish_route(k, o);
  if (o.released) return robot::go_home(k, "no region is left to work on");
  return wait(k, o);
}

robot::Intent Slei3dInspector::inspect(robot::Knowledge& k, const Orders& o,
                                       const robot::Progress& progress) {
  worked_ = true;
  const bool arrived = progress.state == robot::Progress::State::kArrived;
  if (current_ && std::find(o.areas.begin(), o.areas.end(), *current_) == o.areas.end())
    current_.reset();
  if (current_) {
    if (!arrived)
      looking_since_.reset();
    else if (!looking_since_)
      looking_since_ = k.now();
    // What is in view is answered for when the hold is over; there is no need to wait for the no.
    const double look_s = looking_since_ ? (k.now() - *looking_since_).s() : 0;
    const bool refused = look_s > k.mission().inspect.hold_s + kAnswer_s ||
                         (progress.inspected &&
                          progress.inspected->outcome == mission::InspectOutcome::kRefusedView);
    const bool hidden =
        !arrived && open_when_chosen_ && !in_sight(k, k.areas().at(*current_).area, view_.pose);
    if (arrived || (k.position() - moved_to_).norm() > kMoved_m) {
      moved_to_ = k.position();
      moved_at_ = k.now();
    }
    const bool stuck = (k.now() - moved_at_).s() > kStuck_s;
    if (refused || hidden || stuck || progress.blocked_s > kBlockedPose_s) give_up_pose(k, refused);
  }
  if (!current_ && k.now() >= look_again_) next_area(k, o.areas);
  robot::Intent intent;
  intent.activity = mission::Activity::kTravelling;
  if (!current_) {
    // Nothing is visible from what is known here: go nearer, sensing the way.
    const mission::Area& area = k.areas().at(o.areas.front()).area;
    intent.kind = robot::Intent::Kind::kGo;
    intent.goal = area.sighted_from;
    intent.through_unknown = true;
    intent.tolerance_m = 1.0;
    intent.reason = "on the way to areas that are out of sight so far";
    return intent;
  }
  intent.kind = robot::Intent::Kind::kInspect;
  intent.goal = view_.pose;
  intent.use_yaw = true;
  intent.area = *current_;
  intent.area_position = asked_;
  if (arrived) intent.activity = mission::Activity::kInspecting;
  intent.reason =
      "area " + std::to_string(current_->author.value) + "." + std::to_string(current_->key);
  return intent;
}

/// Looks at this very spot whose answers named what is known: whatever else is here does not show
/// itself there.
std::vector<VainLook> Slei3dInspector::looks_of_others(const robot::Knowledge& k,
                                                       const mission::AreaRef& ref) {
  const Vec3& p = k.areas().at(ref).area.position;
  std::vector<VainLook> looks;
  for (const auto& [other, result] : k.results()) {
    const mission::Inspection& i = result.inspection;
    const Vec3 d = i.pose.p - p;
    if (!i.found || (i.area_position - p).norm() > kSameSpot_m) continue;
    looks.push_back({{d.normalized(), d.norm(), 1}, true});
  }
  return looks;
}

/// In the order given; one that has been looked at in vain comes after those that have been less.
void Slei3dInspector::next_area(robot::Knowledge& k, std::vector<mission::AreaRef> areas) {
  std::stable_sort(areas.begin(), areas.end(), [&](const auto& a, const auto& b) {
    return efforts_[a].looks / kLooksInARow < efforts_[b].looks / kLooksInARow;
  });
  for (const mission::AreaRef& ref : areas) {
    if (k.now() >= efforts_[ref].not_before && choose_pose(k, ref)) return;
  }
  look_again_ = k.now() + Duration::from_s(1.0);
}

bool Slei3dInspector::choose_pose(robot::Knowledge& k, const mission::AreaRef& ref) {
  const robot::Stopwatch watch(planning_, mission::PlanningStep::kPath);
  Effort& effort = efforts_[ref];
  if (effort.looks + effort.tries == 0 && effort.in_vain.empty())
    effort.in_vain = looks_of_others(k, ref);
  k.paths().flood(k.position());
  const auto view =
      view_pose(k, k.areas().at(ref).area, effort.in_vain, effort.looks + effort.tries);
  // Beside a known feature refusals are no proof that there is another one: with no good look left,
  // what the others showed has to do.
  const bool settled = effort.open < kDoubted && !sure(k, ref) && explored(k, ref) &&
                       (!view || view->probability < kHopeless);
  if (settled) {
    report_nothing(k, ref);
    return false;
  }
  if (view) {
    view_ = *view;
    open_when_chosen_ = in_sight(k, k.areas().at(ref).area, view_.pose);
    current_ = ref;
    asked_ = spot_to_ask(k, k.areas().at(ref).area, effort.looks);
    looking_since_.reset();
    moved_to_ = k.position();
    moved_at_ = k.now();
    return true;
  }
  ++effort.tries;
  postpone(k, ref);
  return false;
}

/// An area in this very spot was closed without an answer: what could be tried was tried then.
bool Slei3dInspector::given_up_before(const robot::Knowledge& k, const mission::AreaRef& ref) {
  const Vec3& p = k.areas().at(ref).area.position;
  return std::any_of(k.results().begin(), k.results().end(), [&](const auto& r) {
    const mission::Inspection& i = r.second.inspection;
    return !answered(i) && (i.area_position - p).norm() < kSameSpot_m;
  });
}

/// Its explorer says that the area's region is explored, or has moved on to another one.
bool Slei3dInspector::explored(const robot::Knowledge& k, const mission::AreaRef& ref) {
  const auto* health = k.health(ref.author);
  if (!health || health->body.regions.empty()) return false;
  const mission::RegionProgress& p = health->body.regions.front();
  return p.region != k.areas().at(ref).area.region || p.state >= mission::RegionState::kExplored;
}

/// Sighted so often, by what no finding explains, that a refusal never says there is nothing.
bool Slei3dInspector::sure(const robot::Knowledge& k, const mission::AreaRef& ref) {
  return k.areas().at(ref).area.unexplained >= kSureSightings;
}

/// It may have been a sighting of a feature that is known, and not be worth looking from
/// everywhere: sighted once or twice where no spot to ask about is clear of known ones, so that
/// refusals may be about them; or looked at in vain so often that the spot may be one that no
/// camera sees. So may any, in the end: a false area need not be one that can be inspected.
bool Slei3dInspector::may_be_stray(const robot::Knowledge& k, const mission::AreaRef& ref) {
  const mission::Area& area = k.areas().at(ref).area;
  const Effort& effort = efforts_[ref];
  const int vain = effort.looks + effort.tries;
  if (!explored(k, ref)) return false;
  if (vain >= kHopelessLooks) return true;
  if (!known_near(k, area.position)) return false;
  return (!sure(k, ref) && vain >= kManyStrayLooks) ||
         (vain >= kStrayLooks && area.unexplained <= 2 && known_near(k, spot_to_ask(k, area)));
}

/// Refused: look from elsewhere, at once while there is a fair chance. Not to be reached or out of
/// sight: the others first. A refusal beside a known feature may be about that one; when looks that
/// would have shown another were refused so, there is none.
void Slei3dInspector::give_up_pose(robot::Knowledge& k, bool refused) {
  const mission::AreaRef ref = *current_;
  current_.reset();
  Effort& effort = efforts_[ref];
  effort.in_vain.push_back({view_.look, refused});
  ++(refused ? effort.looks : effort.tries);
  if (refused && known_near(k, asked_)) {
    effort.open *= 1 - (1 - kMisled) * view_.probability;
    if (effort.open < kRuledOut && !sure(k, ref)) return report_nothing(k, ref);
  }
  if (may_be_stray(k, ref)) return report_nothing(k, ref);
  if (!refused) postpone(k, ref);
  if (effort.in_vain.size() >= kManyLooks) effort.in_vain.clear();
}

/// The others first: meanwhile the map grows. An area that no pose is found for is reported as not
/// to be seen in the end, but not before its region is explored: until then a better place to look
/// from may still become known. One that was refused has been in reach, and is
/// not given up.
void Slei3dInspector::postpone(robot::Knowledge& k, const mission::AreaRef& ref) {
  Effort& effort = efforts_[ref];
  effort.not_before = k.now() + Duration::from_s(kRetryArea_s);
  if (may_be_stray(k, ref)) return report_nothing(k, ref);
  if (effort.tries < kMaxTries) return;
  const bool try_on = effort.looks > 0 && !given_up_before(k, ref);
  if (!explored(k, ref) || (try_on && effort.rounds++ < kRounds)) {
    effort.tries = kMaxTries / 2;
    effort.not_before = k.now() + Duration::from_s(kRetryUnexplored_s);
    return;
  }
  report_nothing(k, ref);
}

void Slei3dInspector::report_nothing(robot::Knowledge& k, const mission::AreaRef& ref) {
  log::info("area {}.{} is closed without an answer", ref.author.value, ref.key);
  mission::Inspection result;
  result.area = ref;
  result.area_position = k.areas().at(ref).area.position;
  result.pose = k.odometry().pose;
  result.parts = 0;  // no answer
  result.done = k.now();
  k.publish(store::RecordClass::kInspection, robot::result_key(ref), result);
}

void Slei3dInspector::report(robot::Knowledge& k, const mission::Inspected& answer) {
  using mission::InspectOutcome;
  if (answer.outcome != InspectOutcome::kFound && answer.outcome != InspectOutcome::kEmpty) return;
  mission::Inspection result;
  result.area = *current_;
  result.area_position = asked_;
  result.pose = k.odometry().pose;
  result.done = k.now();
  result.found = answer.outcome == mission::InspectOutcome::kFound;
  result.findings = answer.found;
  result.payload_bytes = static_cast<std::uint32_t>(answer.payload.size());
  const std::size_t carried_bytes = radio::Pace(k.mission().radio).record_bytes();
  const std::size_t part_bytes = std::min(
      kImagePart_bytes, std::max(carried_bytes, 2 * kAroundImage_bytes) - kAroundImage_bytes);
  const std::size_t images = (answer.payload.size() + part_bytes - 1) / part_bytes;
  result.parts = static_cast<std::uint32_t>(1 + images);
  k.publish(store::RecordClass::kInspection, robot::result_key(result.area), result);
  result.findings.clear();
  for (std::uint32_t i = 0; i < images; ++i) {
    const auto first = answer.payload.begin() + static_cast<std::ptrdiff_t>(i * part_bytes);
    const auto left = static_cast<std::size_t>(answer.payload.end() - first);
    result.part = i + 1;
    result.payload.assign(first, first + static_cast<std::ptrdiff_t>(std::min(left, part_bytes)));
    k.publish(store::RecordClass::kImage, robot::image_key(result.area, result.part), result);
  }
  current_.reset();
}

robot::Intent Slei3dInspector::wait(robot::Knowledge& k, const Orders& o) {
  robot::Intent intent;
  intent.activity = mission::Activity::kWaiting;
  intent.through_unknown = true;
  intent.tolerance_m = 1.0;
  const double unheard_s = (k.now() - k.last_heard(o.leader).value_or(k.started())).s();
  if (unheard_s > kUnheard_s) {
    intent.kind = robot::Intent::Kind::kGo;
    intent.goal.p = k.config().start.p;
    intent.reason = "explorer unheard: waiting where the station can be met";
    return intent;
  }
  if (!end_) {
    intent.reason = "waiting for work";
    return intent;
  }
  intent.kind = robot::Intent::Kind::kGo;
  intent.goal.p = *end_;
  intent.reason =
      worked_ ? "waiting where the route ends"
              : "waiting at the gathering place of region " + std::to_string(o.region.value);
  return intent;
}

/// Where the last area is looked at from, as far as can be told now.
Vec3 Slei3dInspector::route_end(robot::Knowledge& k, const Orders& o) const {
  const mission::AreaRef ref = o.areas.back();
  const mission::Area& area = k.areas().at(ref).area;
  const auto effort = efforts_.find(ref);
  k.paths().flood(k.position());
  const std::vector<VainLook> none;
  if (const auto view =
          view_pose(k, area, effort == efforts_.end() ? none : effort->second.in_vain, 0))
    return view->pose.p;
  for (const double m : {1.5, 2.0, 2.5, 1.0, 3.0, 4.0}) {
    Vec3 p = area.position + m * (area.sighted_from.p - area.position).normalized();
    if (k.map().traversable(p)) return p;
  }
  return area.sighted_from.p;
}

/// The route as the explorer needs it: where this inspector will be when, if nothing else is
/// allocated. It ends where the explorer was last told that it ends, until the explorer can hear
/// otherwise.
void Slei3dInspector::publish_route(robot::Knowledge& k, const Orders& o) {
  const bool same_region = route_published_ && routed_region_ == o.region;
  const bool listens = k.in_contact(o.leader);
  const bool added = std::any_of(o.areas.begin(), o.areas.end(), [&](const auto& ref) {
    return std::find(routed_.begin(), routed_.end(), ref) == routed_.end();
  });
  const bool late = listens && (k.now() - routed_at_).s() > kRouteAgain_s && !o.areas.empty();
  if (same_region && !added && !late) return;
  if (added || (late && worked_))
    end_ = route_end(k, o);
  else if (!worked_ && o.region != kNoRegion)
    end_ = gathering_place(k.mission(), o.region, k.self());
  routed_ = o.areas;
  routed_region_ = o.region;
  routed_at_ = k.now();
  route_published_ = true;
  mission::Plan plan;
  plan.kind = mission::PlanKind::kRoute;
  SimTime t = k.now();
  Vec3 p = k.position();
  const auto step = [&](const Vec3& place, mission::PlanAction action, const mission::AreaRef& area,
                        double duration_s) {
    t = t + Duration::from_s(nav::travel_time_s(kDetour * (place - p).norm(), k.limits()) + 1.5);
    p = place;
    plan.steps.push_back({{t, {p, 0}}, action, kNoRobot, area, static_cast<float>(duration_s)});
    t = t + Duration::from_s(duration_s);
  };
  for (const mission::AreaRef& ref : o.areas) {
    const mission::Area& area = k.areas().at(ref).area;
    const Vec3 from = area.position + 2.0 * (area.sighted_from.p - area.position).normalized();
    step(from, mission::PlanAction::kInspect, ref, k.mission().inspect.hold_s);
  }
  step(end_.value_or(k.position()), mission::PlanAction::kWait, {}, 0);
  k.publish(store::RecordClass::kPlan, robot::plan_key(mission::PlanKind::kRoute), plan);
}

}  // namespace muster::agent
