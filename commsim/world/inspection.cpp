#include "commsim/world/inspection.h"

#include <algorithm>
#include <cmath>

#include "common/core/hash.h"
#include "common/core/random.h"

namespace muster::world {
namespace {

constexpr Duration kPatience{3'000'000};

}  // namespace

Bytes inspection_payload(std::uint64_t mission_seed, RobotId robot, const Vec3& area,
                         std::uint32_t size) {
  const std::uint64_t seed = Hasher(mission_seed).add(area.x()).add(area.y()).add(area.z()).value();
  Random random(seed, robot, "inspection payload");
  Bytes bytes(size);
  for (std::size_t i = 0; i < bytes.size();) {
    std::uint64_t word = random.next();
    for (int b = 0; b < 8 && i < bytes.size(); ++b, word >>= 8) {
      bytes[i++] = static_cast<std::uint8_t>(word);
    }
  }
  return bytes;
}

InspectionCamera::InspectionCamera(const mission::RobotConfig& robot,
                                   const mission::Mission& mission,
                                   const std::vector<Feature>& features)
    : id_(robot.id),
      vehicle_(robot.vehicle),
      config_(mission.inspect),
      seed_(mission.seed),
      features_(features) {}

std::vector<InspectionCamera::Answer> InspectionCamera::request(const mission::Inspect& inspect,
                                                                SimTime now) {
  std::vector<Answer> cancelled;
  if (inspect.request == 0 || !config_.shared) {
    for (const Action& a : actions_) {
      cancelled.push_back(answer(a, mission::InspectOutcome::kCancelled, now));
    }
    actions_.clear();
  }
  if (inspect.request == 0) return cancelled;
  Action action;
  action.inspect = inspect;
  action.inspect.hold_s = std::max(inspect.hold_s, config_.hold_s);
  action.last_in_view = now;
  for (std::size_t i = 0; i < features_.size(); ++i) {
    if ((features_[i].position - inspect.area).norm() <= config_.match_m) {
      action.candidates.push_back(i);
    }
  }
  action.holds.resize(action.candidates.size());
  actions_.push_back(std::move(action));
  return cancelled;
}

void InspectionCamera::drop() { actions_.clear(); }

bool InspectionCamera::holding() const {
  return std::any_of(actions_.begin(), actions_.end(), [](const Action& a) {
    return a.area.held ||
           std::any_of(a.holds.begin(), a.holds.end(), [](const Hold& h) { return h.held; });
  });
}

bool InspectionCamera::in_reach(const Pose& pose, const Vec3& p) const {
  FieldOfView view = vehicle_.camera;
  view.range_m = config_.range_m;
  return view.contains(pose, vehicle_.pitch_rad, p);
}

bool InspectionCamera::steep(const Vec3& from, const Vec3& p, const Vec3& normal) const {
  const Vec3 d = from - p;
  return d.dot(normal) < std::cos(config_.max_incidence_rad) * d.norm() - 1e-9;
}

bool InspectionCamera::sees_feature(const Surroundings& around, const Pose& pose,
                                    const Feature& f) const {
  return in_reach(pose, f.position) && !steep(pose.p, f.position, f.normal) &&
         around.sees(pose.p, before_surface(f.position, f.normal), id_);
}

bool InspectionCamera::sees_area(const Surroundings& around, const Pose& pose,
                                 const Vec3& area) const {
  if (!in_reach(pose, area)) return false;
  if (!around.sees(pose.p, area, id_, config_.match_m)) return false;
  const Vec3 d = area - pose.p;
  const double distance = d.norm();
  if (distance < 1e-9) return false;
  const auto hit = around.scene().cast(pose.p, d / distance, distance + config_.match_m);
  // A ray that passes an edge beside the surface meets nothing: the area is as well seen as it can
  // be.
  return !hit || !steep(pose.p, pose.p + d / distance * hit->distance_m, hit->normal);
}

std::vector<InspectionCamera::Answer> InspectionCamera::look(const Surroundings& around,
                                                             const Pose& pose, double speed_mps,
                                                             SimTime now) {
  std::vector<Answer> answers;
  const bool still = speed_mps <= config_.max_speed_mps + 1e-9;
  const auto update = [now](Hold& hold, bool in_view) {
    if (in_view && !hold.held) hold.since = now;
    hold.held = in_view;
  };
  std::vector<Action> going_on;
  for (Action& a : actions_) {
    const Duration hold = Duration::from_s(a.inspect.hold_s);
    const auto complete = [&](const Hold& h) { return h.held && now - h.since >= hold; };
    bool under_way = false, any_complete = false;
    for (std::size_t i = 0; i < a.candidates.size(); ++i) {
      update(a.holds[i], still && sees_feature(around, pose, features_[a.candidates[i]]));
      any_complete |= complete(a.holds[i]);
      under_way |= a.holds[i].held && !complete(a.holds[i]);
    }
    update(a.area, still && a.candidates.empty() && sees_area(around, pose, a.inspect.area));
    if (under_way || any_complete || a.area.held) a.last_in_view = now;

    if (any_complete && !under_way) {
      answers.push_back(found(a, now));
    } else if (a.candidates.empty() && complete(a.area)) {
      answers.push_back(answer(a, mission::InspectOutcome::kEmpty, now));
    } else if (now - a.last_in_view >= hold + kPatience) {
      answers.push_back(answer(a, mission::InspectOutcome::kRefusedView, now));
    } else {
      going_on.push_back(std::move(a));
    }
  }
  actions_ = std::move(going_on);
  return answers;
}

InspectionCamera::Answer InspectionCamera::answer(const Action& action,
                                                  mission::InspectOutcome outcome,
                                                  SimTime now) const {
  Answer result;
  result.message.time = now;
  result.message.request = action.inspect.request;
  result.message.outcome = outcome;
  result.area = action.inspect.area;
  return result;
}

InspectionCamera::Answer InspectionCamera::found(const Action& action, SimTime now) const {
  Answer result = answer(action, mission::InspectOutcome::kFound, now);
  const Duration hold = Duration::from_s(action.inspect.hold_s);
  for (std::size_t i = 0; i < action.candidates.size(); ++i) {
    if (!action.holds[i].held || now - action.holds[i].since < hold) continue;
    const Feature& f = features_[action.candidates[i]];
    result.message.found.push_back({f.id, f.type, f.position});
  }
  result.message.payload =
      inspection_payload(seed_, id_, action.inspect.area, config_.payload_bytes);
  return result;
}

}  // namespace muster::world
