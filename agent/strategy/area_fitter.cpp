#include "agent/strategy/area_fitter.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "agent/strategy/surface_belief.h"

namespace muster::agent {
namespace {

constexpr double kSameArea_m = 0.5;   // RULES "Sighting and inspecting"
constexpr double kSamePlace_m = 0.3;  // asked for here already
constexpr double kNear_m = 0.75;      // where a sighting may be a stray one of something known
constexpr double kDoubt_s = 40;       // for so long other looks may confirm or explain a sighting
constexpr double kDoubtsEvery_s = 10;
constexpr double kBoxMargin_m = 0.4;
constexpr double kMoved_m = 0.08;
constexpr double kOfMiddle_sigmas = 3.7;  // a sighting this far from the middle is of another
constexpr std::size_t kSure = 2;          // sightings that make a doubtful area one
constexpr std::size_t kTestFrom = 6;      // sightings of an area that may be two
constexpr int kReviews = 2;

bool concerns(const mission::Mission& mission, RegionId region, const Vec3& p) {
  if (region.value < mission.boxes.size() && mission.boxes[region.value].contains(p, kBoxMargin_m))
    return true;
  return std::none_of(mission.boxes.begin(), mission.boxes.end(),
                      [&](const Box& b) { return b.contains(p); });
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
  if (seen.empty()) return area.position;
  Vec3 sum = Vec3::Zero();
  for (const Seen& s : seen) sum += s.sighting.position;
  return sum / static_cast<double>(seen.size());
}

Vec3 AreaFitter::Fit::towards() const {
  if (seen.empty()) return area.normal;
  Vec3 sum = Vec3::Zero();
  for (const Seen& s : seen) sum += s.towards;
  return sum.normalized();
}

bool AreaFitter::Fit::seen_in(std::size_t look) const {
  return std::any_of(seen.begin(), seen.end(), [&](const Seen& s) { return s.look == look; });
}

void AreaFitter::take(robot::Knowledge& k, const mission::Sightings& sightings, RegionId region) {
  region_ = region;
  for (const Seen& seen : news(k, sightings)) add(k, seen, region);
}

void AreaFitter::recall(robot::Knowledge& k) {
  for (const auto& [ref, known] : k.areas()) {
    if (ref.author != k.self() || k.inspected(ref)) continue;
    Fit& fit = fits_.emplace_back();
    fit.ref = ref;
    fit.since = k.now();
    fit.area = known.area;
    fit.published = known.area.position;
    fit.published_sightings = known.area.unexplained;  // of how many it is the mean is not kept
  }
  for (const auto& [explored, look] : k.looks()) {
    if (explored == kNoRegion) continue;
    region_ = explored;
    for (const Seen& seen : news(k, look)) {
      Fit* fit = open_fit(k, seen);
      if (!fit) fit = &begin(k, seen, explored);
      fit->seen.push_back(seen);
    }
  }
  std::erase_if(fits_, [](const Fit& fit) { return fit.seen.empty(); });
}

/// Sightings that are nobody's, and that nothing explains.
std::vector<Seen> AreaFitter::news(const robot::Knowledge& k, const mission::Sightings& sightings) {
  std::vector<mission::Sighting> own;
  for (const mission::Sighting& s : sightings.seen) {
    if (!taken_up(k, s.position)) own.push_back(s);
  }
  log_.renew(k);
  std::vector<Seen> left = log_.take(k, sightings.sensor, own);
  std::erase_if(left, [&](const Seen& seen) { return asked_enough(k, seen.sighting.position); });
  return left;
}

bool AreaFitter::has_fit(const mission::AreaRef& ref) const {
  return std::any_of(fits_.begin(), fits_.end(), [&](const Fit& f) { return f.ref == ref; });
}

/// Somebody else has made an area of it, or this explorer has, at a start whose looks are lost, and
/// it waits for its inspector. (What was inspected explains sightings by what was found: LookLog.)
bool AreaFitter::taken_up(const robot::Knowledge& k, const Vec3& p) const {
  return std::any_of(k.areas().begin(), k.areas().end(), [&](const auto& a) {
    return !k.inspected(a.first) && (a.second.area.position - p).norm() < kSameArea_m &&
           !has_fit(a.first);
  });
}

/// A false area close to a true one answers with the true one again and again; where several are
/// close together there may be another.
bool AreaFitter::asked_enough(const robot::Knowledge& k, const Vec3& p) const {
  const auto here = [&](const Vec3& q) { return (q - p).norm() < kSamePlace_m; };
  const auto earlier = [&](const auto& a) {  // by an earlier start
    return a.first.author == k.self() && here(a.second.area.position) && k.inspected(a.first) &&
           !has_fit(a.first);
  };
  const auto asked = std::count_if(k.areas().begin(), k.areas().end(), earlier) +
                     std::count_if(fits_.begin(), fits_.end(),
                                   [&](const Fit& f) { return f.closed && here(f.mean()); });
  if (asked <= kReviews) return false;
  std::set<FeatureId> beside;
  for (const auto& [ref, result] : k.results()) {
    for (const mission::Finding& f : result.inspection.findings) {
      if ((f.position - p).norm() < kSameArea_m) beside.insert(f.feature);
    }
  }
  return static_cast<std::size_t>(asked) > kReviews + std::max<std::size_t>(beside.size(), 1) - 1;
}

bool AreaFitter::in_doubt() const {
  return std::any_of(fits_.begin(), fits_.end(), [](const Fit& f) { return !f.ref; });
}

/// Sightings of a fit with a result that neither this result nor any other explains.
std::vector<Seen> AreaFitter::unexplained(const robot::Knowledge& k, const Fit& fit) const {
  std::vector<Seen> left;
  if (asked_enough(k, fit.mean())) return left;
  for (const Seen& seen : fit.seen) {
    if (seen.reviews >= kReviews || log_.explained(seen)) continue;
    left.push_back(seen);
    ++left.back().reviews;
  }
  return left;
}

void AreaFitter::review(robot::Knowledge& k, bool explored) {
  const bool over = explored && !explored_;
  explored_ = explored;
  const bool doubts_due = k.now() >= doubts_again_;
  const bool news = log_.renew(k);
  if (!news && !over && !doubts_due) return;
  doubts_again_ = k.now() + Duration::from_s(kDoubtsEvery_s);
  tell_apart(k);
  std::vector<std::pair<Seen, RegionId>> again;
  for (Fit& fit : fits_) {
    if (fit.closed || !fit.ref) continue;
    if (!k.inspected(*fit.ref)) {
      if (news) count_unexplained(k, fit);
      continue;
    }
    fit.closed = true;
    for (const Seen& seen : unexplained(k, fit)) again.push_back({seen, fit.area.region});
  }
  for (const auto& [seen, region] : again) add(k, seen, region);
  settle_doubts(k, over);
}

/// (Its position stays the mean of all: without those nearest to a known feature it would be off.)
void AreaFitter::count_unexplained(robot::Knowledge& k, Fit& fit) const {
  const auto left = static_cast<std::uint32_t>(std::count_if(
      fit.seen.begin(), fit.seen.end(), [&](const Seen& seen) { return !log_.explained(seen); }));
  if (left == fit.area.unexplained) return;
  fit.area.unexplained = left;
  k.publish(store::RecordClass::kArea, fit.ref->key, fit.area);
}

/// Of sightings that are more likely of two features than of one: those of a feature that was found
/// and explained all of them, and those of an area whose result is not in.
void AreaFitter::tell_apart(robot::Knowledge& k) {
  const double sigma_m = k.mission().sensing.sighting_sigma_m;
  const auto open = [&](const Seen& s) {
    return std::any_of(fits_.begin(), fits_.end(), [&](const Fit& f) {
      return !f.closed && std::any_of(f.seen.begin(), f.seen.end(), [&](const Seen& o) {
        return o.look == s.look && o.place == s.place;
      });
    });
  };
  for (const Seen& seen : log_.second_features(sigma_m)) {
    // (Those of an area that was answered just now are reviewed with it.)
    if (!open(seen) && !asked_enough(k, seen.sighting.position)) add(k, seen, region_);
  }
  for (std::size_t f = 0; f < fits_.size(); ++f) {
    Fit& fit = fits_[f];
    if (fit.closed || !fit.ref || k.inspected(*fit.ref) || fit.seen.size() < kTestFrom ||
        std::exchange(fit.tested, fit.seen.size()) == fit.seen.size())
      continue;
    std::vector<Vec3> points;
    for (const Seen& s : fit.seen) points.push_back(s.sighting.position);
    const std::vector<std::size_t> others = second_source(points, sigma_m, std::nullopt);
    if (others.empty()) continue;
    std::vector<Seen> stay, leave;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool leaves = std::binary_search(others.begin(), others.end(), i);
      (leaves ? leave : stay).push_back(fit.seen[i]);
    }
    fit.seen = std::move(stay);
    publish(k, fit);
    const RegionId region = fit.area.region;
    Fit& second = begin(k, leave.front(), region);  // `fit` may have moved
    second.seen = std::move(leave);
    publish(k, second);
  }
}

bool AreaFitter::concerns_us(const robot::Knowledge& k, const Fit& fit) const {
  return concerns(k.mission(), region_, fit.mean());
}

/// What has been explained meanwhile is forgotten. What is not after a while is asked for: surfaces
/// that are hard to see are sighted once, and a look settles it.
void AreaFitter::settle_doubts(robot::Knowledge& k, bool over) {
  std::vector<std::size_t> settled;
  for (std::size_t i = 0; i < fits_.size(); ++i) {
    if (fits_[i].ref) continue;
    std::erase_if(fits_[i].seen, [&](const Seen& seen) { return log_.explained(seen); });
    const bool aged = !fits_[i].seen.empty() && (k.now() - fits_[i].since).s() > kDoubt_s;
    if (fits_[i].seen.empty() || taken_up(k, fits_[i].mean()))
      settled.push_back(i);
    else if (over || (aged && (explored_ || concerns_us(k, fits_[i]))))
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
    const auto sightings = static_cast<double>(std::max<std::size_t>(f.seen.size(), 1));
    const double spread = std::sqrt(1 + 1 / sightings);
    if (d > kOfMiddle_sigmas * k.mission().sensing.sighting_sigma_m * spread) continue;
    if (f.closed || (f.ref && k.inspected(*f.ref))) continue;
    if (d >= best_m || f.seen_in(seen.look)) continue;
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

AreaFitter::Fit& AreaFitter::begin(const robot::Knowledge& k, const Seen& seen, RegionId region) {
  Fit& fit = fits_.emplace_back();
  fit.since = k.now();
  fit.area.region = region;
  fit.area.feature_type = seen.sighting.feature_type;
  fit.area.priority = seen.sighting.priority;
  fit.area.skill = seen.sighting.skill;
  return fit;
}

void AreaFitter::add(robot::Knowledge& k, const Seen& seen, RegionId region) {
  Fit* fit = open_fit(k, seen);
  const bool sure = !fit && !doubtful(k, seen);
  if (!fit) fit = &begin(k, seen, region);
  fit->seen.push_back(seen);
  if (!fit->ref) {
    if (concerns_us(k, *fit) && (sure || fit->seen.size() >= kSure)) publish(k, *fit);
    return;
  }
  const auto count = static_cast<std::uint32_t>(fit->seen.size());
  const bool better =
      (fit->mean() - fit->published).norm() > kMoved_m || count >= 2 * fit->published_sightings;
  if (better && !k.inspected(*fit->ref)) publish(k, *fit);
}

/// Whence it was sighted most squarely, by the map: along that line nothing hides it, and an
/// inspector may look along it as well.
Pose AreaFitter::squarest(const robot::Knowledge& k, const Fit& fit) {
  if (fit.seen.size() == 1) return fit.seen.front().sensor;
  const SurfaceBelief belief = belief_at(k, fit.mean(), fit.towards(), 0.1);
  const Seen* best = &fit.seen.front();
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
  fit.area.unexplained = count;  // `review` takes off what is explained
  fit.area.sigma_m = static_cast<float>(k.mission().sensing.sighting_sigma_m / std::sqrt(count));
  fit.area.normal = fit.towards();
  fit.area.position = fit.mean();
  fit.area.sighted_from = squarest(k, fit);
  fit.published = fit.area.position;
  fit.published_sightings = count;
  k.publish(store::RecordClass::kArea, fit.ref->key, fit.area);
}

}  // namespace muster::agent
