#include "agent/strategy/area_fitter.h"

#include <algorithm>
#include <cmath>

#include "agent/strategy/surface_belief.h"

namespace muster::agent {
namespace {

constexpr double kSameArea_m = 0.5;     // RULES "Sighting and inspecting"
constexpr double kSameFeature_m = 0.4;  // four sigma of a sighting
constexpr double kNear_m = 0.75;        // where a sighting may be a stray one of something known
constexpr double kDoubt_s = 40;         // for so long other looks may confirm or explain a sighting
// How far the middle of n sightings may lie from the feature: 4.5 sigma, and never less than…
constexpr double kMiddle_m = 0.45, kMiddleLeast_m = 0.2;
constexpr double kDoubtsEvery_s = 10;
constexpr double kBoxMargin_m = 0.4;
constexpr double kMoved_m = 0.08;
constexpr double kPlainCos = 0.5;    // directions this close can be of one surface, whatever it is
constexpr double kOtherSide = 0.08;  // of showing itself to the sighter: less is another surface
constexpr std::size_t kSure = 2;     // sightings that make a doubtful area one
constexpr int kReviews = 2;

bool concerns(const mission::Mission& mission, RegionId region, const Vec3& p) {
  if (region.value < mission.boxes.size() && mission.boxes[region.value].contains(p, kBoxMargin_m))
    return true;
  return std::none_of(mission.boxes.begin(), mission.boxes.end(),
                      [&](const Box& b) { return b.contains(p); });
}

SurfaceBelief belief_at(const robot::Knowledge& k, const Vec3& p, const Vec3& towards,
                        double sigma_m) {
  mission::Area at;
  at.position = p;
  at.normal = towards;
  at.sighted_from.p = p + towards;
  at.sigma_m = static_cast<float>(sigma_m);
  return {k.map(), at, k.mission().inspect, k.config().vehicle};
}

/// Can who looked at a feature along `seen` have sighted the one that was found at `p` by a look
/// along `found` (units, towards the cameras)?
bool shows(const robot::Knowledge& k, const Vec3& p, const Vec3& found, const Vec3& seen) {
  if (found.dot(seen) > kPlainCos) return true;
  SurfaceBelief belief = belief_at(k, p, found, 0);
  belief.accept(found);
  return belief.shows(seen) > kOtherSide;
}

/// Near a finding, or where nothing was found.
bool beside_known(const robot::Knowledge& k, const Vec3& p) {
  const auto near = [&](const Vec3& q) { return (p - q).norm() < kNear_m; };
  return std::any_of(k.results().begin(), k.results().end(), [&](const auto& r) {
    const mission::Inspection& i = r.second.inspection;
    if (i.findings.empty()) return near(i.area_position);
    return std::any_of(i.findings.begin(), i.findings.end(),
                       [&](const auto& f) { return near(f.position); });
  });
}

}  // namespace

Vec3 AreaFitter::Fit::mean() const {
  Vec3 sum = Vec3::Zero();
  for (const Seen& s : seen) sum += s.sighting.position;
  return sum / static_cast<double>(seen.size());
}

Vec3 AreaFitter::Fit::towards() const {
  Vec3 sum = Vec3::Zero();
  for (const Seen& s : seen) sum += s.towards;
  return sum.normalized();
}

bool AreaFitter::Fit::seen_in(std::uint64_t look) const {
  return std::any_of(seen.begin(), seen.end(), [&](const Seen& s) { return s.look == look; });
}

void AreaFitter::take(robot::Knowledge& k, const mission::Sightings& sightings, RegionId region) {
  ++looks_;
  std::set<FeatureId> taken;
  for (const mission::Sighting& s : sightings.seen) {
    if (!concerns(k.mission(), region, s.position)) continue;
    // Somebody else's area is not fitted again.
    const bool theirs = std::any_of(k.areas().begin(), k.areas().end(), [&](const auto& a) {
      return a.first.author != k.self() &&
             (a.second.area.position - s.position).norm() < kSameArea_m;
    });
    if (theirs) continue;
    const Vec3 towards = (sightings.sensor.p - s.position).normalized();
    const Seen seen{s, towards, sightings.sensor, looks_, 0};
    if (!explained(k, seen, &taken)) add(k, seen, region);
  }
}

/// A false area close to a true one answers with the true one again and again.
bool AreaFitter::asked_enough(const Vec3& p) const {
  const auto asked = std::count_if(fits_.begin(), fits_.end(), [&](const Fit& f) {
    return f.closed && (f.mean() - p).norm() < kSameFeature_m;
  });
  return asked > kReviews;
}

/// By a finding near by whose surface shows itself to the sighter (one that no other sighting of
/// the same look was `taken` for), or by an inspection that found nothing here.
bool AreaFitter::explained(const robot::Knowledge& k, const Seen& seen,
                           std::set<FeatureId>* taken) const {
  const Vec3& p = seen.sighting.position;
  if (asked_enough(p)) return true;
  const mission::Finding* nearest = nullptr;
  double nearest_m = kSameFeature_m;
  for (const auto& [ref, result] : k.results()) {
    const mission::Inspection& i = result.inspection;
    const double off_m = (i.area_position - p).norm();
    if (off_m > 2 * kSameArea_m) continue;
    if (!i.found && off_m < kSameFeature_m) return true;
    for (const mission::Finding& f : i.findings) {
      const double d = (f.position - p).norm();
      if (d >= nearest_m || (taken && taken->contains(f.feature))) continue;
      if (!shows(k, f.position, (i.pose.p - f.position).normalized(), seen.towards)) continue;
      nearest = &f;
      nearest_m = d;
    }
  }
  if (nearest && taken) taken->insert(nearest->feature);
  return nearest != nullptr;
}

/// What other sightings of the same look are nearer to: not sighted twice in one look.
std::set<FeatureId> AreaFitter::claimed_beside(const robot::Knowledge& k, const Seen& seen) const {
  std::set<FeatureId> claimed;
  for (const Fit& fit : fits_) {
    for (const Seen& other : fit.seen) {
      const Vec3& p = other.sighting.position;
      const double apart_m = (p - seen.sighting.position).norm();
      if (other.look != seen.look || apart_m <= 0 || apart_m > 2 * kSameFeature_m) continue;
      for (const auto& [ref, result] : k.results()) {
        for (const mission::Finding& f : result.inspection.findings) {
          const double d = (f.position - p).norm();
          if (d < kSameFeature_m && d < (f.position - seen.sighting.position).norm())
            claimed.insert(f.feature);
        }
      }
    }
  }
  return claimed;
}

/// Sightings of a fit with a result that the result, and all others, do not explain: each for
/// itself, or all together when their middle lies off every finding.
std::vector<AreaFitter::Seen> AreaFitter::unexplained(const robot::Knowledge& k,
                                                      const Fit& fit) const {
  const mission::Inspection& result = k.results().at(*fit.ref).inspection;
  const double off_m =
      std::max(kMiddleLeast_m, kMiddle_m / std::sqrt(static_cast<double>(fit.seen.size())));
  const Vec3 mean = fit.mean();
  const bool middle =
      !result.found || asked_enough(mean) ||
      std::any_of(result.findings.begin(), result.findings.end(),
                  [&](const auto& f) { return (f.position - mean).norm() < off_m; });
  std::vector<Seen> left;
  for (const Seen& seen : fit.seen) {
    std::set<FeatureId> taken = claimed_beside(k, seen);
    if (seen.reviews >= kReviews || (middle && explained(k, seen, &taken))) continue;
    left.push_back(seen);
    ++left.back().reviews;
  }
  return left;
}

void AreaFitter::review(robot::Knowledge& k, bool explored) {
  const bool over = explored && !explored_;
  explored_ = explored;
  const bool doubts_due = k.now() >= doubts_again_;
  if (k.results().size() == results_ && !over && !doubts_due) return;
  results_ = k.results().size();
  doubts_again_ = k.now() + Duration::from_s(kDoubtsEvery_s);
  std::vector<std::pair<Seen, RegionId>> again;
  for (Fit& fit : fits_) {
    if (fit.closed || !fit.ref || !k.inspected(*fit.ref)) continue;
    fit.closed = true;
    for (const Seen& seen : unexplained(k, fit)) again.push_back({seen, fit.area.region});
  }
  for (const auto& [seen, region] : again) add(k, seen, region);
  settle_doubts(k, over);
}

/// What has been explained meanwhile is forgotten. What is not after a while is asked for: surfaces
/// that are hard to see are sighted once, and a look settles it.
void AreaFitter::settle_doubts(robot::Knowledge& k, bool over) {
  std::vector<std::size_t> settled;
  for (std::size_t i = 0; i < fits_.size(); ++i) {
    if (fits_[i].ref) continue;
    std::erase_if(fits_[i].seen, [&](const Seen& seen) { return explained(k, seen); });
    if (fits_[i].seen.empty())
      settled.push_back(i);
    else if (over || (k.now() - fits_[i].since).s() > kDoubt_s)
      publish(k, fits_[i]);
  }
  for (auto i = settled.rbegin(); i != settled.rend(); ++i)
    fits_.erase(fits_.begin() + static_cast<std::ptrdiff_t>(*i));
}

AreaFitter::Fit* AreaFitter::open_fit(const robot::Knowledge& k, const Seen& seen) {
  Fit* best = nullptr;
  double best_m = kSameArea_m;
  for (Fit& f : fits_) {
    const double d = (f.mean() - seen.sighting.position).norm();
    if (f.closed || d >= best_m || f.seen_in(seen.look)) continue;
    const Vec3 towards = f.towards();
    const bool plain = towards.dot(seen.towards) > kPlainCos;
    if (!plain && belief_at(k, f.mean(), towards, 0.1).shows(seen.towards) < kOtherSide) continue;
    best = &f;
    best_m = d;
  }
  return best;
}

/// It may be a stray sighting of something known: whatever that is, a second one will tell.
bool AreaFitter::doubtful(const robot::Knowledge& k, const Seen& seen) const {
  const auto near = [&](const Vec3& p) { return (p - seen.sighting.position).norm() < kNear_m; };
  bool beside = false;
  for (const Fit& f : fits_) {
    if (!near(f.mean())) continue;
    if (!f.closed && f.seen_in(seen.look)) return false;  // one look, two sightings: two features
    beside = true;
  }
  return beside || beside_known(k, seen.sighting.position);
}

void AreaFitter::add(robot::Knowledge& k, const Seen& seen, RegionId region) {
  Fit* fit = open_fit(k, seen);
  const bool sure = !fit && !doubtful(k, seen);
  if (!fit) {
    fit = &fits_.emplace_back();
    fit->since = k.now();
    fit->area.region = region;
    fit->area.feature_type = seen.sighting.feature_type;
    fit->area.priority = seen.sighting.priority;
    fit->area.skill = seen.sighting.skill;
  }
  fit->seen.push_back(seen);
  if (!fit->ref) {
    if (sure || fit->seen.size() >= kSure) publish(k, *fit);
    return;
  }
  const auto count = static_cast<std::uint32_t>(fit->seen.size());
  const bool better =
      (fit->mean() - fit->published).norm() > kMoved_m || count >= 2 * fit->published_count;
  if (better && !k.inspected(*fit->ref)) publish(k, *fit);
}

/// Whence it was sighted most squarely, by the map: along that line nothing hides it, and an
/// inspector may look along it as well.
Pose AreaFitter::squarest(const robot::Knowledge& k, const Fit& fit) {
  if (fit.seen.size() == 1) return fit.seen.front().sensor;
  const SurfaceBelief belief = belief_at(k, fit.mean(), fit.towards(), 0.1);
  const Seen* best = nullptr;
  double most = -1;
  for (const Seen& s : fit.seen) {
    const double faces = belief.faces(s.towards);
    if (faces > most) most = faces, best = &s;
  }
  return best->sensor;
}

void AreaFitter::publish(robot::Knowledge& k, Fit& fit) {
  if (!fit.ref) fit.ref = {k.self(), k.store().new_key(store::RecordClass::kArea)};
  const auto count = static_cast<std::uint32_t>(fit.seen.size());
  fit.area.sightings = count;
  fit.area.sigma_m = static_cast<float>(k.mission().sensing.sighting_sigma_m / std::sqrt(count));
  fit.area.normal = fit.towards();
  fit.area.position = fit.mean();
  fit.area.sighted_from = squarest(k, fit);
  fit.published = fit.area.position;
  fit.published_count = count;
  k.publish(store::RecordClass::kArea, fit.ref->key, fit.area);
}

}  // namespace muster::agent
