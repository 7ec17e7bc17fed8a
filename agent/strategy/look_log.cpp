#include "agent/strategy/look_log.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace muster::agent {
namespace {

// A sighting farther off is of something else: of one feature, one in a thousand is. At three sigma
// it would be three in a hundred, and each is a spot at which an inspector looks many times in
// vain.
constexpr double kOfIt_sigmas = 4;
constexpr double kBeside_sigmas = 2;  // a quarter of one feature's sightings are farther off: these
constexpr double kOtherSideBeside = 0.5;  // are of it only where it is likelier than not to show
constexpr double kNothing_m = 0.5;        // around where nothing was found, by the rule
constexpr double kConcerned_m = 1.0;
// Gain in log-likelihood that tells two sources from one: what the best split of noise gains grows
// with the sightings. In a simulation 100 of one source gained 41 at most, 56 with both fitted.
constexpr double kGain = 16, kGainPerPoint = 0.33, kGainPerFittedPoint = 0.47;
constexpr int kRounds = 3;  // of sharing the points out
constexpr std::size_t kSeeds = 12;

Vec3 mean(const std::vector<Vec3>& points, const std::vector<bool>& of, bool which) {
  Vec3 sum = Vec3::Zero();
  double n = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (of[i] == which) sum += points[i], ++n;
  }
  return n > 0 ? Vec3(sum / n) : Vec3(Vec3::Constant(1e9));
}

}  // namespace

SurfaceBelief belief_at(const robot::Knowledge& k, const Vec3& p, const Vec3& towards,
                        double sigma_m) {
  mission::Area at;
  at.position = p;
  at.normal = towards;
  at.sighted_from.p = p + towards;
  at.sigma_m = static_cast<float>(sigma_m);
  return {k.map(), at, k.mission().inspect, k.config().vehicle};
}

std::vector<std::size_t> second_source(const std::vector<Vec3>& points, double sigma_m,
                                       const std::optional<Vec3>& first) {
  const std::size_t n = points.size();
  const Vec3 one = first ? *first : mean(points, std::vector<bool>(n, true), true);
  double best_gain = kGain + (first ? kGainPerPoint : kGainPerFittedPoint) * static_cast<double>(n);
  std::vector<std::size_t> best;
  std::vector<Vec3> seeds = points;
  std::stable_sort(seeds.begin(), seeds.end(), [&](const Vec3& p, const Vec3& q) {
    return (p - one).squaredNorm() > (q - one).squaredNorm();
  });
  seeds.resize(std::min(n, kSeeds));
  for (const Vec3& seed : seeds) {
    Vec3 a = one, b = seed;
    std::vector<bool> second(n);
    for (int round = 0; round < kRounds; ++round) {
      for (std::size_t i = 0; i < n; ++i)
        second[i] = (points[i] - b).squaredNorm() < (points[i] - a).squaredNorm();
      b = mean(points, second, true);
      if (!first) a = mean(points, second, false);
    }
    double gain = 0;
    std::vector<std::size_t> group;
    for (std::size_t i = 0; i < n; ++i) {
      const double left = (points[i] - (second[i] ? b : a)).squaredNorm();
      gain += ((points[i] - one).squaredNorm() - left) / (2 * sigma_m * sigma_m);
      if (second[i]) group.push_back(i);
    }
    if (gain > best_gain && group.size() < n + (first ? 1 : 0)) {
      best_gain = gain;
      best = std::move(group);
    }
  }
  return best;
}

Seen LookLog::seen(std::size_t look, std::size_t place) const {
  const Look& l = looks_[look];
  const mission::Sighting& s = l.seen[place].sighting;
  return {s, (l.sensor.p - s.position).normalized(), l.sensor, look, place, 0};
}

std::vector<Seen> LookLog::take(const robot::Knowledge& k, const Pose& sensor,
                                const std::vector<mission::Sighting>& sightings) {
  if (sightings.empty()) return {};
  Look& look = looks_.emplace_back();
  look.sensor = sensor;
  for (const mission::Sighting& s : sightings) look.seen.push_back({s, {}, {}, {}});
  explain(k, look);
  std::vector<Seen> left;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (look.seen[i].source == Source::kUnknown) left.push_back(seen(looks_.size() - 1, i));
  }
  return left;
}

bool LookLog::explained(const Seen& s) const {
  return looks_[s.look].seen[s.place].source != Source::kUnknown;
}

bool LookLog::renew(const robot::Knowledge& k) {
  if (taken_in_.size() == k.results().size()) return false;
  std::vector<Vec3> news;
  for (const auto& [ref, result] : k.results()) {
    if (!taken_in_.insert(ref).second) continue;
    const mission::Inspection& i = result.inspection;
    if (!i.found && answered(i)) {
      nothing_.push_back(i.area_position);
      news.push_back(i.area_position);
    }
    for (const mission::Finding& f : i.findings) {
      Feature& feature = features_[f.feature];
      feature.position = f.position;
      feature.from.push_back((i.pose.p - f.position).normalized());
      feature.belief.reset();
      news.push_back(f.position);
    }
  }
  const auto concerned = [&](const Entry& e) {
    return std::any_of(news.begin(), news.end(), [&](const Vec3& p) {
      return (p - e.sighting.position).squaredNorm() < kConcerned_m * kConcerned_m;
    });
  };
  for (Look& look : looks_) {
    if (std::any_of(look.seen.begin(), look.seen.end(), concerned)) explain(k, look);
  }
  return true;
}

/// The chance that who looked along `towards` can have sighted it, by where it was inspected from.
double LookLog::shows(const robot::Knowledge& k, Feature& feature, const Vec3& towards) {
  if (std::any_of(feature.from.begin(), feature.from.end(),
                  [&](const Vec3& from) { return from.dot(towards) > kPlainCos; }))
    return 1;
  if (!feature.belief) {
    feature.belief = belief_at(k, feature.position, feature.from.front(), 0);
    for (const Vec3& from : feature.from) feature.belief->accept(from);
  }
  return feature.belief->shows(towards);
}

void LookLog::explain(const robot::Knowledge& k, Look& look) {
  const double sigma_m = k.mission().sensing.sighting_sigma_m;
  std::vector<std::tuple<double, std::size_t, FeatureId>> pairs;
  for (std::size_t i = 0; i < look.seen.size(); ++i) {
    Entry& e = look.seen[i];
    const Vec3& p = e.sighting.position;
    const bool nothing = std::any_of(nothing_.begin(), nothing_.end(),
                                     [&](const Vec3& q) { return (p - q).norm() < kNothing_m; });
    e.source = nothing ? Source::kNothing : Source::kUnknown;
    if (nothing) continue;
    const Vec3 towards = (look.sensor.p - p).normalized();
    for (auto& [id, feature] : features_) {
      const double off_m = (feature.position - p).norm();
      if (off_m > kOfIt_sigmas * sigma_m || e.other_than == id) continue;
      const double least = off_m > kBeside_sigmas * sigma_m ? kOtherSideBeside : kOtherSide;
      if (shows(k, feature, towards) > least) pairs.emplace_back(off_m, i, id);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::set<FeatureId> used;
  for (const auto& [off_m, i, id] : pairs) {
    Entry& e = look.seen[i];
    if (e.source != Source::kUnknown || !used.insert(id).second) continue;
    e.source = Source::kFeature;
    e.feature = id;
  }
}

std::vector<Seen> LookLog::second_features(double sigma_m) {
  struct Of {
    std::vector<Vec3> points;
    std::vector<Seen> seen;
  };
  std::map<FeatureId, Of> by_feature;
  for (std::size_t l = 0; l < looks_.size(); ++l) {
    for (std::size_t i = 0; i < looks_[l].seen.size(); ++i) {
      const Entry& e = looks_[l].seen[i];
      if (e.source != Source::kFeature) continue;
      by_feature[e.feature].points.push_back(e.sighting.position);
      by_feature[e.feature].seen.push_back(seen(l, i));
    }
  }
  std::vector<Seen> found;
  for (const auto& [id, of] : by_feature) {
    if (std::exchange(features_.at(id).tested, of.points.size()) == of.points.size()) continue;
    for (const std::size_t i : second_source(of.points, sigma_m, features_.at(id).position)) {
      Entry& e = looks_[of.seen[i].look].seen[of.seen[i].place];
      e.other_than = id;
      e.source = Source::kUnknown;
      found.push_back(of.seen[i]);
    }
  }
  return found;
}

}  // namespace muster::agent
