#include "agent/strategy/area_fitter.h"

#include <algorithm>
#include <cmath>

namespace muster::agent {
namespace {

constexpr double kSameArea_m = 0.5;     // RULES "Sighting and inspecting"
constexpr double kSameFeature_m = 0.4;  // four sigma of a sighting
// An empty answer says that no feature lies within 0.5 m; one a little farther off may be sighted
// in between.
constexpr double kNothingHere_m = 0.3;
constexpr double kBoxMargin_m = 0.4;
constexpr double kMoved_m = 0.08;
constexpr double kSameSideCos = -0.26;  // 105°: one feature is seen from within 90° of its normal
constexpr int kReviews = 2;

bool concerns(const mission::Mission& mission, RegionId region, const Vec3& p) {
  if (region.value < mission.boxes.size() && mission.boxes[region.value].contains(p, kBoxMargin_m))
    return true;
  return std::none_of(mission.boxes.begin(), mission.boxes.end(),
                      [&](const Box& b) { return b.contains(p); });
}

}  // namespace

void AreaFitter::take(robot::Knowledge& k, const mission::Sightings& sightings, RegionId region) {
  for (const mission::Sighting& s : sightings.seen) {
    if (!concerns(k.mission(), region, s.position)) continue;
    // Somebody else's area is not fitted again.
    const bool theirs = std::any_of(k.areas().begin(), k.areas().end(), [&](const auto& a) {
      return a.first.author != k.self() &&
             (a.second.area.position - s.position).norm() < kSameArea_m;
    });
    if (theirs) continue;
    const Seen seen{s, (sightings.sensor.p - s.position).normalized(), sightings.sensor, 0};
    if (!explained(k, seen)) add(k, seen, region);
  }
}

/// By a finding near by that was looked at from this side, or by an inspection that found nothing
/// here.
bool AreaFitter::explained(const robot::Knowledge& k, const Seen& seen) const {
  const Vec3& p = seen.sighting.position;
  // A false area close to a true one answers with the true one again and again.
  const auto asked = std::count_if(fits_.begin(), fits_.end(), [&](const Fit& f) {
    return f.closed && (f.mean() - p).norm() < kSameFeature_m;
  });
  if (asked > kReviews) return true;
  return std::any_of(k.results().begin(), k.results().end(), [&](const auto& r) {
    const mission::Inspection& i = r.second.inspection;
    if ((i.area_position - p).norm() > 2 * kSameArea_m) return false;
    if (!i.found) return (i.area_position - p).norm() < kNothingHere_m;
    const bool same_side =
        (i.pose.p - i.area_position).normalized().dot(seen.towards) > kSameSideCos;
    return same_side &&
           std::any_of(i.findings.begin(), i.findings.end(), [&](const mission::Finding& f) {
             return (f.position - p).norm() < kSameFeature_m;
           });
  });
}

void AreaFitter::review(robot::Knowledge& k) {
  if (k.results().size() == results_) return;
  results_ = k.results().size();
  std::vector<std::pair<Seen, RegionId>> again;
  for (Fit& fit : fits_) {
    if (fit.closed || !k.inspected(fit.ref)) continue;
    fit.closed = true;
    for (Seen seen : fit.seen) {
      if (explained(k, seen) || ++seen.reviews > kReviews) continue;
      again.push_back({seen, fit.area.region});
    }
  }
  for (const auto& [seen, region] : again) add(k, seen, region);
}

AreaFitter::Fit* AreaFitter::open_fit(const Seen& seen) {
  Fit* best = nullptr;
  double best_m = kSameArea_m;
  for (Fit& f : fits_) {
    const double d = (f.mean() - seen.sighting.position).norm();
    if (f.closed || d >= best_m || f.towards.normalized().dot(seen.towards) < kSameSideCos)
      continue;
    best = &f;
    best_m = d;
  }
  return best;
}

void AreaFitter::add(robot::Knowledge& k, const Seen& seen, RegionId region) {
  Fit* fit = open_fit(seen);
  if (!fit) {
    fit = &fits_.emplace_back();
    fit->ref = {k.self(), k.store().new_key(store::RecordClass::kArea)};
    fit->area.region = region;
    fit->area.feature_type = seen.sighting.feature_type;
    fit->area.priority = seen.sighting.priority;
    fit->area.skill = seen.sighting.skill;
  }
  fit->seen.push_back(seen);
  fit->sum += seen.sighting.position;
  fit->towards += seen.towards;
  const auto count = static_cast<std::uint32_t>(fit->seen.size());
  fit->area.sightings = count;
  fit->area.sigma_m = static_cast<float>(k.mission().sensing.sighting_sigma_m / std::sqrt(count));
  fit->area.normal = fit->towards.normalized();
  const bool nearer = count == 1 || (seen.sensor.p - seen.sighting.position).norm() <
                                        (fit->area.sighted_from.p - fit->mean()).norm();
  if (nearer) fit->area.sighted_from = seen.sensor;
  const bool better =
      (fit->mean() - fit->published).norm() > kMoved_m || count >= 3 * fit->published_count;
  if (count == 1 || (better && !k.inspected(fit->ref))) publish(k, *fit);
}

void AreaFitter::publish(robot::Knowledge& k, Fit& fit) {
  fit.area.position = fit.mean();
  fit.published = fit.area.position;
  fit.published_count = static_cast<std::uint32_t>(fit.seen.size());
  k.publish(store::RecordClass::kArea, fit.ref.key, fit.area);
}

}  // namespace muster::agent
