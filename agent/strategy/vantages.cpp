#include "agent/strategy/vantages.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace muster::agent {
namespace {

constexpr double kPitch_m = 1.0;
constexpr double kNear_m = 6.0;
constexpr double kUnseenValue = 60;  // a place never looked at: about a frustum of unknown
constexpr std::size_t kLooks = 50, kRefreshes = 10;  // panoramas per decision
constexpr double kLeastValue = 3;                    // less is left to the viewpoints of clusters
constexpr double kFresh_s = 0.3;
constexpr double kGlance_s = 0.35;  // a scan comes twice a second
constexpr double kDecide_s = 0.2;   // coming to rest, starting again
constexpr double kApart_m = 1.5, kApart_rad = 0.8;

}  // namespace

bool straight(const map::VoxelMap& map, const Vec3& a, const Vec3& b) {
  const double length = (b - a).norm();
  const int steps = static_cast<int>(std::ceil(length / (0.7 * map.config().resolution_m)));
  for (int i = 1; i <= steps; ++i) {
    if (!map.traversable(a + (b - a) * (static_cast<double>(i) / steps))) return false;
  }
  return true;
}

double flight_s(double way_m, const Vec3& direction, double yaw_now_rad, double yaw_rad,
                const nav::Limits& limits, const Vec3& v_mps) {
  double travel_s = nav::travel_time_s(way_m, limits);
  // What is already in motion that way need not be sped up; any other motion must be stopped first.
  const double speed = v_mps.norm();
  if (speed > 0.1) {
    const bool along = v_mps.dot(direction) > 0.7 * speed * direction.norm();
    travel_s += (along ? -0.5 : 1.0) * speed / limits.accel_mps2;
    travel_s = std::max(0.0, travel_s);
  }
  const double turn_s = std::abs(wrap_angle(yaw_rad - yaw_now_rad)) / limits.yaw_rate_radps;
  return std::max(travel_s, turn_s) + kDecide_s;
}

View price(const Pose& pose, const map::Worth& worth, double arrive_s, SimTime now,
           const ViewPrice& price) {
  View glance{pose, worth, arrive_s, false, worth.unknown_m3, 0};
  glance.rate = glance.value / (arrive_s + kGlance_s);
  View look{pose, worth, arrive_s, true, worth.unknown_m3 + price.owed_weight * worth.owed_m2, 0};
  double at_s = (price.next_look - now).s();
  while (at_s < arrive_s) at_s += price.look_period_s;
  look.rate = look.value / (at_s + 0.1);
  return look.rate > glance.rate ? look : glance;
}

Vantages::Vantages(const Box& box, const map::VoxelMap& map) {
  // One place outside each side of the box: what lies at its rim is well seen from there.
  const Vec3 low = box.low() - Vec3::Constant(kPitch_m),
             high = box.high() + Vec3::Constant(kPitch_m);
  const double edge = map.config().resolution_m;
  first_ = map.center(map.key(low));
  const auto count = [&](double l, double h) {
    return std::max(1, static_cast<int>(std::floor((h - l + edge / 2) / kPitch_m)) + 1);
  };
  nx_ = count(low.x(), high.x());
  ny_ = count(low.y(), high.y());
  nz_ = count(low.z(), high.z());
  if (map.config().ground) {
    first_.z() = map.config().ride_height_m;
    nz_ = 1;
  }
  places_.resize(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) *
                 static_cast<std::size_t>(nz_));
}

Vec3 Vantages::spot(std::size_t place) const {
  const int i = static_cast<int>(place);
  const Eigen::Vector3i cell(i % nx_, i / nx_ % ny_, i / nx_ / ny_);
  return first_ + kPitch_m * cell.cast<double>();
}

std::vector<std::size_t> Vantages::around(const map::VoxelMap& map, const Vec3& p) const {
  const Vec3 low = (p - first_ - Vec3::Constant(kNear_m)) / kPitch_m;
  const Vec3 high = (p - first_ + Vec3::Constant(kNear_m)) / kPitch_m;
  const auto from = [](double v) { return std::max(0, static_cast<int>(std::ceil(v))); };
  const auto to = [](double v, int n) { return std::min(n - 1, static_cast<int>(std::floor(v))); };
  std::vector<std::size_t> result;
  for (int z = from(low.z()); z <= to(high.z(), nz_); ++z) {
    for (int y = from(low.y()); y <= to(high.y(), ny_); ++y) {
      for (int x = from(low.x()); x <= to(high.x(), nx_); ++x) {
        const int cell = (z * ny_ + y) * nx_ + x;
        const auto place = static_cast<std::size_t>(cell);
        const Vec3 s = spot(place);
        if ((s - p).squaredNorm() > kNear_m * kNear_m || !map.traversable(s)) continue;
        result.push_back(place);
      }
    }
  }
  return result;
}

void Vantages::look(std::size_t place, const map::Targets& targets, const ViewPrice& price,
                    SimTime now) {
  const map::Panorama all = targets.panorama(spot(place));
  Place& p = places_[place];
  p.most = 0;
  for (std::size_t h = 0; h < all.headings.size(); ++h) {
    p.unknown_m3[h] = static_cast<float>(all.headings[h].unknown_m3);
    p.owed_m2[h] = static_cast<float>(all.headings[h].owed_m2);
    p.most =
        std::max(p.most, p.unknown_m3[h] + static_cast<float>(price.owed_weight) * p.owed_m2[h]);
  }
  p.seen = true;
  p.seen_at = now;
}

std::vector<View> Vantages::best(robot::Knowledge& k, const map::Targets& targets,
                                 const ViewPrice& price, std::size_t count,
                                 const std::function<bool(const Pose&)>& spent) {
  const SimTime now = k.now();
  const Vec3 here = k.position();
  const double yaw = k.odometry().pose.yaw_rad;
  const nav::Limits& limits = k.limits();
  std::vector<std::size_t> places = around(k.map(), here);

  // Surfaces that came into view since make old places better than they were: the oldest anew.
  std::vector<std::size_t> old;
  for (const std::size_t p : places) {
    if (places_[p].seen) old.push_back(p);
  }
  std::stable_sort(old.begin(), old.end(), [&](std::size_t a, std::size_t b) {
    return places_[a].seen_at < places_[b].seen_at;
  });
  for (std::size_t i = 0; i < std::min(old.size(), kRefreshes); ++i)
    look(old[i], targets, price, now);

  const auto bound = [&](std::size_t place) {
    const Place& p = places_[place];
    const double arrive_s = nav::travel_time_s((spot(place) - here).norm(), limits);
    return Bound{(p.seen ? static_cast<double>(p.most) : kUnseenValue) / (arrive_s + kGlance_s),
                 place};
  };
  const auto less = [](const Bound& a, const Bound& b) {
    return a.rate != b.rate ? a.rate < b.rate : a.place > b.place;
  };
  std::vector<Bound> heap;
  heap.reserve(places.size());
  for (const std::size_t p : places) heap.push_back(bound(p));
  std::make_heap(heap.begin(), heap.end(), less);

  const auto best_heading = [&](const Vec3& s, const auto& worth) {
    View best;
    for (int h = 0; h < map::Panorama::kHeadings; ++h) {
      const double to = wrap_angle(map::Panorama::yaw_rad(h));
      const double arrive_s =
          flight_s((s - here).norm(), s - here, yaw, to, limits, k.odometry().velocity_mps);
      const View v =
          agent::price({s, to}, worth(static_cast<std::size_t>(h)), arrive_s, now, price);
      if (v.value >= kLeastValue && v.rate > best.rate && !spent(v.pose)) best = v;
    }
    return best;
  };
  std::vector<View> found;
  const map::Panorama on_the_spot = targets.panorama(here);
  const View turn = best_heading(here, [&](std::size_t h) { return on_the_spot.headings[h]; });
  if (turn.rate > 0) found.push_back(turn);
  double floor_rate = 0;  // of the last that will be taken
  std::size_t looks = 0;
  while (!heap.empty() && heap.front().rate > floor_rate) {
    std::pop_heap(heap.begin(), heap.end(), less);
    const std::size_t place = heap.back().place;
    heap.pop_back();
    Place& p = places_[place];
    if (!p.seen || (now - p.seen_at).s() > kFresh_s) {
      if (looks++ == kLooks) break;
      look(place, targets, price, now);
      heap.push_back(bound(place));
      std::push_heap(heap.begin(), heap.end(), less);
      continue;
    }
    const Vec3 s = spot(place);
    if (!straight(k.map(), here, s)) continue;
    const View best = best_heading(s, [&](std::size_t h) {
      return map::Worth{static_cast<double>(p.unknown_m3[h]), static_cast<double>(p.owed_m2[h])};
    });
    if (best.rate <= 0) continue;
    found.push_back(best);
    std::stable_sort(found.begin(), found.end(),
                     [](const View& a, const View& b) { return a.rate > b.rate; });
    std::vector<View> kept;
    for (const View& v : found) {
      const bool apart = std::ranges::all_of(kept, [&](const View& o) {
        return (o.pose.p - v.pose.p).norm() > kApart_m ||
               std::abs(wrap_angle(o.pose.yaw_rad - v.pose.yaw_rad)) > kApart_rad;
      });
      if (apart && kept.size() < count) kept.push_back(v);
    }
    found = std::move(kept);
    if (!found.empty()) floor_rate = found.size() < count ? 0.4 * found[0].rate : found.back().rate;
  }
  return found;
}

}  // namespace muster::agent
