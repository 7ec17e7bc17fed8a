#include "common/route/tour.h"

#include <algorithm>
#include <bitset>
#include <unordered_map>

#include "common/core/error.h"
#include "common/core/random.h"

namespace muster::route {
namespace {

constexpr double kFar_s = 1e7;  ///< "no way", finite so that sums stay ordered
constexpr double kGain = 1e-9, kRounding = 1e-6;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::size_t kExact = 14, kMaxStops = 256;
constexpr std::size_t kFirstWidth = 1000, kWider = 8;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

using Set = std::bitset<kMaxStops>;
using Order = std::vector<std::uint32_t>;

/// A tour that has begun. Waiting costs `wait_weight` of what travel does, so that the cost of a
/// whole tour is wait_weight · (time spent) + `cost`: of two labels at one stop with the same stops
/// behind them the one that is earlier and has the smaller `cost` is never worse.
struct Label {
  double free_at_s = 0;  ///< done at its last stop
  double cost = 0;       ///< of lateness, and of the travel that the time does not count
  double bound = 0;      ///< no tour that begins like this costs less
  std::uint32_t parent = kNone;
  std::uint32_t next = kNone;  ///< in the list of its set
  std::uint32_t stop = 0;
  bool alive = true;
  bool dominates(const Label& o) const {
    return free_at_s <= o.free_at_s + kGain && cost <= o.cost + kGain;
  }
};

/// The problem, and what follows from it for every tour.
class Model {
 public:
  explicit Model(const TourProblem& problem)
      : p_(problem), n_(static_cast<std::uint32_t>(problem.stops.size())) {
    find_shortest();
    find_precedence();
    for (std::uint32_t s = 0; s < n_; ++s) {
      double in = kInf;
      for (std::uint32_t place = 0; place <= n_; ++place) {
        if (place != s + 1) in = std::min(in, shortest_[place][s + 1]);
      }
      least_in_.push_back(in);
      service_s_ += p_.stops[s].service_s;
      soft_ = soft_ || !hard(s);
    }
    if (p_.end) {
      service_s_ += p_.end->service_s;
      for (std::uint32_t place = n_ > 0 ? 1 : 0; place <= n_; ++place)
        least_end_ = std::min(least_end_, shortest_[place][n_ + 1]);
    } else {
      least_end_ = 0;
    }
  }

  std::uint32_t stops() const { return n_; }
  const Stop& stop(std::uint32_t s) const { return s < n_ ? p_.stops[s] : *p_.end; }
  bool has_end() const { return p_.end.has_value(); }
  Label start() const { return {.free_at_s = p_.now_s}; }
  double way_s(std::uint32_t place, std::uint32_t stop) const {
    return std::min(p_.travel_s[place][stop + 1], kFar_s);
  }

  /// On from `place` to `s`; nullopt: too late for its hard window, when that is kNeverLate too.
  std::optional<Label> drive(const Label& label, std::uint32_t place, std::uint32_t s,
                             double hard_weight = kNeverLate) const {
    const Stop& there = stop(s);
    const double way = way_s(place, s), arrive = label.free_at_s + way;
    Label next{.stop = s};
    next.cost = label.cost + (1 - p_.wait_weight) * way;
    if (const double late = arrive - there.until_s; late > 0) {
      const double weight = std::min(there.late_weight, hard_weight);
      if (weight != kNeverLate)
        next.cost += weight * late;
      else if (late > kGain)
        return std::nullopt;
    }
    next.free_at_s = std::max(arrive, there.from_s) + there.service_s;
    return next;
  }

  /// Of a whole tour.
  double cost(const Label& label) const {
    return p_.wait_weight * (label.free_at_s - p_.now_s - service_s_) + label.cost;
  }

  /// Hard stops that have to come before `stop`.
  const Set& before(std::uint32_t stop) const { return before_[stop]; }

  /// Every hard window that is left can still be reached in time, each for itself.
  bool alive(const Label& label, const Set& seen) const {
    const auto& way = shortest_[label.stop + 1];
    for (std::uint32_t s = 0; s < n_; ++s) {
      if (!seen[s] && label.free_at_s + way[s + 1] > latest_[s]) return false;
    }
    return label.free_at_s + way[n_ + 1] <= latest_[n_];
  }

  /// What all tours with the same stops left have before them.
  struct Rest {
    double ways_s = 0;  ///< every stop has to be driven to
    double service_s = 0;
    double opens_s = -kInf;  ///< when the last is over at the earliest
    // Only where some windows are soft:
    std::vector<std::uint32_t> stops;
    std::vector<double> steps_s;  ///< way and stay of each, shortest first
    std::vector<double> until_s;  ///< of soft ones, earliest first
    double late_weight = kInf;    ///< the least of the soft ones
  };
  Rest rest(const Set& seen) const {
    Rest r;
    r.ways_s = least_end_;
    r.service_s = p_.end ? p_.end->service_s : 0;
    for (std::uint32_t s = 0; s < n_; ++s) {
      if (seen[s]) continue;
      const Stop& stop = p_.stops[s];
      r.ways_s += least_in_[s];
      r.service_s += stop.service_s;
      r.opens_s = std::max(r.opens_s, stop.from_s + stop.service_s);
      if (!soft_) continue;
      r.stops.push_back(s);
      r.steps_s.push_back(least_in_[s] + stop.service_s);
      if (stop.late_weight == kNeverLate) continue;
      r.until_s.push_back(std::max(stop.from_s, stop.until_s) + stop.service_s);
      r.late_weight = std::min(r.late_weight, stop.late_weight);
    }
    std::sort(r.steps_s.begin(), r.steps_s.end());
    std::sort(r.until_s.begin(), r.until_s.end());
    return r;
  }

  /// No tour that begins like this costs less.
  double bound(const Label& label, const Rest& rest) const {
    // Late for each at least as if it came next; and, one after the other, as if each took the
    // shortest way there is, in the order of their windows.
    double each = 0, in_order = 0, t = label.free_at_s;
    const auto& way = shortest_[label.stop + 1];
    for (const std::uint32_t s : rest.stops) {
      const Stop& stop = p_.stops[s];
      const double late = label.free_at_s + way[s + 1] - stop.until_s;
      if (late > 0 && stop.late_weight != kNeverLate) each += stop.late_weight * late;
    }
    for (std::size_t i = 0; i < rest.until_s.size(); ++i) {
      t += rest.steps_s[i];
      in_order += std::max(0.0, t - rest.until_s[i]);
    }
    if (in_order > 0) each = std::max(each, rest.late_weight * in_order);
    Label end;
    end.free_at_s = std::max(label.free_at_s + rest.ways_s + rest.service_s, rest.opens_s);
    end.cost = label.cost + (1 - p_.wait_weight) * rest.ways_s + each;
    return cost(end);
  }

  /// The whole tour in this order; nullopt: too late for somebody.
  std::optional<Label> along(const Order& order, double hard_weight = kNeverLate) const {
    Label label = start();
    std::uint32_t place = 0;
    for (const std::uint32_t s : order) {
      const auto next = drive(label, place, s, hard_weight);
      if (!next) return std::nullopt;
      label = *next;
      place = s + 1;
    }
    return p_.end ? drive(label, place, n_, hard_weight) : label;
  }

  Tour describe(Order order) const {
    Tour tour;
    Label label = start();
    std::uint32_t place = 0;
    const auto add = [&](std::uint32_t s) {
      const double way = way_s(place, s), arrive = label.free_at_s + way;
      tour.arrive_s.push_back(arrive);
      tour.travel_s += way;
      tour.wait_s += std::max(0.0, stop(s).from_s - arrive);
      if (stop(s).late_weight != kNeverLate) tour.late_s += std::max(0.0, arrive - stop(s).until_s);
      label = drive(label, place, s).value();
      place = s + 1;
    };
    for (const std::uint32_t s : order) add(s);
    if (p_.end) add(n_);
    tour.cost = tour.bound = cost(label);
    tour.order = std::move(order);
    return tour;
  }

 private:
  bool hard(std::uint32_t s) const { return stop(s).late_weight == kNeverLate; }

  /// Shortest ways (ways need not keep the triangle inequality), and when one has to leave for a
  /// hard window at the latest.
  void find_shortest() {
    const std::size_t places = n_ + 2;
    shortest_.assign(places, std::vector<double>(places, 0));
    for (std::size_t i = 0; i < places; ++i) {
      for (std::uint32_t s = 0; s < n_ + (p_.end ? 1 : 0); ++s) {
        if (i < p_.travel_s.size() && i != s + 1)
          shortest_[i][s + 1] = way_s(static_cast<std::uint32_t>(i), s);
      }
    }
    for (std::size_t k = 1; k <= n_; ++k) {
      for (std::size_t i = 0; i < places; ++i) {
        for (std::size_t j = 1; j < places; ++j)
          shortest_[i][j] = std::min(shortest_[i][j], shortest_[i][k] + shortest_[k][j]);
      }
    }
    for (std::uint32_t s = 0; s < n_; ++s)
      latest_.push_back(hard(s) ? stop(s).until_s + kGain : kInf);
    latest_.push_back(p_.end && hard(n_) ? p_.end->until_s + kGain : kInf);
  }

  void find_precedence() {
    before_.resize(n_);
    for (std::uint32_t s = 0; s < n_; ++s) {
      const double done =
          std::max(p_.now_s + shortest_[0][s + 1], stop(s).from_s) + stop(s).service_s;
      for (std::uint32_t other = 0; other < n_; ++other) {
        if (other != s && done + shortest_[s + 1][other + 1] > latest_[other])
          before_[s].set(other);
      }
    }
  }

  const TourProblem& p_;
  std::uint32_t n_;
  double service_s_ = 0, least_end_ = kInf;
  bool soft_ = false;  // some stop is
  std::vector<std::vector<double>> shortest_;
  std::vector<double> latest_, least_in_;
  std::vector<Set> before_;
};

/// Dynamic programming over (stops visited, last one), layer by layer, with the labels that nothing
/// dominates. A layer that is wider than allowed keeps the labels of least bound.
class LayeredSearch {
 public:
  LayeredSearch(const Model& model, std::size_t width, double good, std::uint64_t max_labels)
      : m_(model), width_(width), good_(good), max_labels_(max_labels) {}

  /// The best tour, if it costs at most `good` and is within the width.
  std::optional<Order> solve() {
    const std::uint32_t n = m_.stops();
    Layer layer = begin();
    for (std::uint32_t depth = 1; depth < n; ++depth) {
      narrow(layer);
      layer = extend(layer);
      if (layer.labels.empty() || labels_ > max_labels_) return std::nullopt;
    }
    return best_of(layer);
  }

  std::uint64_t labels() const { return labels_; }
  /// Nothing was left out.
  bool complete() const { return dropped_ == kInf && labels_ <= max_labels_; }
  /// What was left out costs no less.
  double dropped() const { return labels_ > max_labels_ ? -kInf : dropped_; }

 private:
  struct Layer {
    std::vector<Label> labels;
    std::vector<Set> sets;             // visited
    std::vector<std::uint32_t> first;  // per set: its first label
    std::vector<std::uint32_t> last;
    std::unordered_map<Set, std::uint32_t> index;
  };

  void offer(Layer& layer, const Set& seen, const Label& label) {
    ++labels_;
    const auto [at, fresh] =
        layer.index.try_emplace(seen, static_cast<std::uint32_t>(layer.sets.size()));
    if (fresh) {
      layer.sets.push_back(seen);
      layer.first.push_back(kNone);
      layer.last.push_back(kNone);
    }
    const std::uint32_t set = at->second;
    for (std::uint32_t i = layer.first[set]; i != kNone; i = layer.labels[i].next) {
      const Label& other = layer.labels[i];
      if (other.alive && other.stop == label.stop && other.dominates(label)) return;
    }
    for (std::uint32_t i = layer.first[set]; i != kNone; i = layer.labels[i].next) {
      Label& other = layer.labels[i];
      if (other.stop == label.stop && label.dominates(other)) other.alive = false;
    }
    const auto here = static_cast<std::uint32_t>(layer.labels.size());
    (layer.last[set] == kNone ? layer.first[set] : layer.labels[layer.last[set]].next) = here;
    layer.last[set] = here;
    layer.labels.push_back(label);
  }

  /// Whoever comes from there in time to `s`, and may still be better than what is known.
  void drive(Layer& layer, const Label& from, std::uint32_t parent, std::uint32_t place,
             std::uint32_t s, const Set& seen, const Model::Rest& rest) {
    auto next = m_.drive(from, place, s);
    if (!next || !m_.alive(*next, seen)) return;
    next->parent = parent;
    next->bound = m_.bound(*next, rest);
    if (next->bound <= good_) offer(layer, seen, *next);
  }

  Layer begin() {
    Layer layer;
    for (std::uint32_t s = 0; s < m_.stops(); ++s) {
      const Set seen = Set().set(s);
      if (m_.before(s).none()) drive(layer, m_.start(), kNone, 0, s, seen, m_.rest(seen));
    }
    return layer;
  }

  /// Its labels by last stop, so that of equally good tours always the same one is found.
  std::vector<std::uint32_t> of_set(const Layer& layer, std::uint32_t set) const {
    std::vector<std::uint32_t> list;
    for (std::uint32_t i = layer.first[set]; i != kNone; i = layer.labels[i].next) {
      if (layer.labels[i].alive) list.push_back(i);
    }
    std::stable_sort(list.begin(), list.end(),
                     [&](auto a, auto b) { return layer.labels[a].stop < layer.labels[b].stop; });
    return list;
  }

  Layer extend(const Layer& layer) {
    auto& parents = parents_.emplace_back();
    Layer next;
    for (std::uint32_t set = 0; set < layer.sets.size() && labels_ <= max_labels_; ++set) {
      const Set& seen = layer.sets[set];
      const auto labels = of_set(layer, set);
      const auto first = static_cast<std::uint32_t>(parents.size());
      for (const std::uint32_t i : labels)
        parents.push_back({layer.labels[i].parent, layer.labels[i].stop});
      for (std::uint32_t s = 0; s < m_.stops() && !labels.empty(); ++s) {
        if (seen[s] || (m_.before(s) & ~seen).any()) continue;
        Set then = seen;
        then.set(s);
        const Model::Rest rest = m_.rest(then);
        for (std::uint32_t i = 0; i < labels.size(); ++i) {
          const Label& label = layer.labels[labels[i]];
          drive(next, label, first + i, label.stop + 1, s, then, rest);
        }
      }
    }
    return next;
  }

  void narrow(Layer& layer) {
    std::vector<std::pair<double, std::uint32_t>> ranked;
    for (std::uint32_t i = 0; i < layer.labels.size(); ++i) {
      if (layer.labels[i].alive) ranked.emplace_back(layer.labels[i].bound, i);
    }
    if (ranked.size() <= width_) return;
    const auto cut = ranked.begin() + static_cast<std::ptrdiff_t>(width_);
    std::nth_element(ranked.begin(), cut, ranked.end());
    dropped_ = std::min(dropped_, cut->first);
    for (auto r = cut; r != ranked.end(); ++r) layer.labels[r->second].alive = false;
  }

  std::optional<Order> best_of(const Layer& layer) const {
    double best = good_ + kGain;
    std::uint32_t best_label = kNone;
    for (std::uint32_t set = 0; set < layer.sets.size(); ++set) {
      for (const std::uint32_t i : of_set(layer, set)) {
        const Label& label = layer.labels[i];
        const auto whole =
            m_.has_end() ? m_.drive(label, label.stop + 1, m_.stops()) : std::optional(label);
        if (!whole || m_.cost(*whole) >= best - kGain) continue;
        best = m_.cost(*whole);
        best_label = i;
      }
    }
    if (best_label == kNone) return std::nullopt;
    Order order{layer.labels[best_label].stop};
    std::uint32_t parent = layer.labels[best_label].parent;
    for (auto step = parents_.rbegin(); step != parents_.rend(); ++step) {
      order.push_back((*step)[parent].second);
      parent = (*step)[parent].first;
    }
    std::reverse(order.begin(), order.end());
    return order;
  }

  const Model& m_;
  std::size_t width_;
  double good_;
  std::uint64_t max_labels_, labels_ = 0;
  double dropped_ = kInf;
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> parents_;  // per layer
};

/// Insertion by closing time, then ruin and recreate: some stops are taken out and put back where
/// they cost least. Counted work.
class Insertion {
 public:
  explicit Insertion(const Model& model) : m_(model) {}

  Order solve(std::uint64_t work) {
    std::vector<std::uint32_t> by_window(m_.stops());
    for (std::uint32_t s = 0; s < by_window.size(); ++s) by_window[s] = s;
    std::stable_sort(by_window.begin(), by_window.end(),
                     [&](auto a, auto b) { return m_.stop(a).until_s < m_.stop(b).until_s; });
    Order best;
    double cost = 0;
    for (const std::uint32_t s : by_window) cost = insert(best, s);
    while (driven_ < work) {
      Order order = best;
      const std::vector<std::uint32_t> out = ruin(order);
      double now = 0;
      for (const std::uint32_t s : out) now = insert(order, s);
      if (now > cost) continue;
      cost = now;
      best = std::move(order);
    }
    return best;
  }

 private:
  static constexpr double kMissed = 1e4;  // cost of a second after a hard window
  static constexpr std::uint64_t kMostOut = 8;

  /// Takes out neighbours in the order, or any.
  std::vector<std::uint32_t> ruin(Order& order) {
    std::vector<std::uint32_t> out;
    const std::uint64_t n = std::min<std::uint64_t>(2 + random_.below(kMostOut), order.size());
    const bool neighbours = random_.chance(0.5);
    std::uint64_t at = random_.below(order.size() - n + 1);
    for (std::uint64_t i = 0; i < n; ++i) {
      if (!neighbours) at = random_.below(order.size());
      out.push_back(order[at]);
      order.erase(order.begin() + static_cast<std::ptrdiff_t>(at));
    }
    for (std::size_t i = out.size(); i > 1; --i) std::swap(out[i - 1], out[random_.below(i)]);
    return out;
  }

  /// Where it costs least; returns what the tour costs then.
  double insert(Order& order, std::uint32_t stop) {
    double best = kInf;
    std::size_t where = 0;
    order.push_back(stop);
    for (std::size_t i = order.size(); i-- > 0;) {
      if (i + 1 < order.size()) std::swap(order[i], order[i + 1]);
      const double cost = m_.cost(m_.along(order, kMissed).value());
      if (cost >= best - kGain) continue;
      best = cost;
      where = i;
    }
    std::rotate(order.begin(), order.begin() + 1,
                order.begin() + static_cast<std::ptrdiff_t>(where) + 1);
    driven_ += order.size() * order.size();
    return best;
  }

  const Model& m_;
  Random random_{1, kNoRobot, "tour"};
  std::uint64_t driven_ = 0;
};

}  // namespace

std::optional<Tour> plan_tour(const TourProblem& problem) {
  const std::size_t n = problem.stops.size();
  MUSTER_CHECK(n <= kMaxStops);
  MUSTER_CHECK(problem.travel_s.size() == n + 1 + (problem.end ? 1 : 0));
  MUSTER_CHECK(problem.wait_weight >= 0 && problem.wait_weight <= 1);
  const Model model(problem);
  if (n == 0) return model.along({}) ? std::optional(model.describe({})) : std::nullopt;

  Order best = Insertion(model).solve(n <= kExact ? n * n * n : problem.max_labels / 4);
  double cost = kInf, bound = -kInf;
  if (const auto whole = model.along(best)) cost = model.cost(*whole);
  std::uint64_t labels = 0;
  for (std::size_t width = n <= kExact ? kNone : kFirstWidth;; width *= kWider) {
    const std::uint64_t left = n <= kExact ? ~0ull : problem.max_labels - labels;
    LayeredSearch search(model, width, cost + kRounding, left);
    if (auto found = search.solve()) {
      best = std::move(*found);
      cost = model.cost(model.along(best).value());
    }
    bound = std::max(bound, search.dropped());
    labels += search.labels();
    if (search.complete() || labels >= problem.max_labels) break;
  }
  if (cost == kInf) return std::nullopt;
  Tour tour = model.describe(std::move(best));
  tour.bound = std::min(tour.cost, bound);
  return tour;
}

}  // namespace muster::route
