#include "agent/strategy/area_fitter.h"

#include <algorithm>

namespace muster::agent {
namespace {

constexpr double kSameArea_m = 0.5;   // RULES "Sighting and inspecting"
constexpr double kBoxMargin_m = 0.4;  // four sigma of a sighting
constexpr double kMoved_m = 0.08;

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
    Fit* best = nullptr;
    double best_m = kSameArea_m;
    for (Fit& f : fits_) {
      const double d = (f.mean() - s.position).norm();
      if (d < best_m) best = &f, best_m = d;
    }
    if (!best) {
      Fit fit;
      fit.ref = {k.self(), k.store().new_key(store::RecordClass::kArea)};
      fit.area.region = region;
      fit.area.feature_type = s.feature_type;
      fit.area.priority = s.priority;
      fit.area.skill = s.skill;
      fits_.push_back(fit);
      best = &fits_.back();
      ++new_;
    }
    best->sum += s.position;
    ++best->count;
    best->area.sightings = best->count;
    best->area.sigma_m =
        static_cast<float>(k.mission().sensing.sighting_sigma_m / std::sqrt(best->count));
    const bool nearer = best->count == 1 || (sightings.sensor.p - s.position).norm() <
                                                (best->area.sighted_from.p - best->mean()).norm();
    if (nearer) best->area.sighted_from = sightings.sensor;
    best->towards += (sightings.sensor.p - s.position).normalized();
    best->area.normal = best->towards.normalized();
    const bool better = (best->mean() - best->published).norm() > kMoved_m ||
                        best->count >= 3 * best->published_count;
    if (best->count == 1 || (better && !k.inspected(best->ref))) publish(k, *best);
  }
}

void AreaFitter::publish(robot::Knowledge& k, Fit& fit) {
  fit.area.position = fit.mean();
  fit.published = fit.area.position;
  fit.published_count = fit.count;
  k.publish(store::RecordClass::kArea, fit.ref.key, fit.area);
}

}  // namespace muster::agent
