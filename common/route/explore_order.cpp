#include "common/route/explore_order.h"

#include <algorithm>
#include <limits>

#include "common/core/error.h"

namespace muster::route {
namespace {

/// Stands for "no way" in sums and differences, where an infinity would give NaN.
constexpr double kFar_s = 1e7;

/// The depth-first search of Alg. 1. Node numbers are those of `OrderProblem::travel_s`.
class LongestPath {
 public:
  LongestPath(const OrderProblem& problem, std::vector<std::uint32_t> nodes)
      : problem_(problem), nodes_(std::move(nodes)), used_(nodes_.size(), false) {}

  std::vector<std::uint32_t> solve() {
    extend(0, 0);
    return best_;
  }

 private:
  double to_meeting(std::uint32_t node) const {
    return problem_.meeting ? problem_.travel_s[node].back() : 0;
  }

  void extend(std::uint32_t at, double spent_s) {
    // Strictly longer only, so that of equal paths the one through nearer viewpoints stays.
    if (spent_s > best_s_) {
      best_s_ = spent_s;
      best_ = path_;
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (used_[i]) continue;
      const double then_s = spent_s + problem_.travel_s[at][nodes_[i]];
      if (!(then_s < kFar_s) || then_s + to_meeting(nodes_[i]) > problem_.budget_s) continue;
      used_[i] = true;
      path_.push_back(nodes_[i]);
      extend(nodes_[i], then_s);
      path_.pop_back();
      used_[i] = false;
    }
  }

  const OrderProblem& problem_;
  std::vector<std::uint32_t> nodes_;
  std::vector<bool> used_;
  std::vector<std::uint32_t> path_, best_;
  double best_s_ = -1;
};

/// Viewpoint nodes (1…n) with a way to them, nearest first.
std::vector<std::uint32_t> reachable_by_distance(const OrderProblem& problem) {
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t i = 1; i <= problem.gain.size(); ++i) {
    if (problem.travel_s[0][i] < kFar_s) nodes.push_back(i);
  }
  std::stable_sort(nodes.begin(), nodes.end(),
                   [&](auto a, auto b) { return problem.travel_s[0][a] < problem.travel_s[0][b]; });
  return nodes;
}

Order finish(const OrderProblem& problem, const std::vector<std::uint32_t>& nodes) {
  Order order;
  std::uint32_t at = 0;
  for (const auto node : nodes) {
    order.visit.push_back(node - 1);
    order.length_s += problem.travel_s[at][node];
    at = node;
  }
  if (problem.meeting) order.length_s += problem.travel_s[at].back();
  return order;
}

/// An open tour being improved: start fixed, end free or at the meeting.
class OpenTour {
 public:
  explicit OpenTour(const OrderProblem& problem) : problem_(problem) {}

  std::vector<std::uint32_t> solve(const std::vector<std::uint32_t>& nodes) {
    for (const auto node : nodes) insert_cheapest(node);
    // Every pass is O(n²) and improves; small instances stop by themselves long before the bound.
    for (int pass = 0; pass < kPasses; ++pass) {
      const bool turned = reverse_best();
      const bool moved = move_best();
      if (!turned && !moved) break;
    }
    return tour_;
  }

 private:
  static constexpr int kPasses = 400;
  static constexpr double kGain_s = 1e-9;

  double cost(std::uint32_t a, std::uint32_t b) const {
    return std::min(problem_.travel_s[a][b], kFar_s);
  }
  /// Node at tour position i; −1 is the robot. `end()` is the meeting or nothing.
  std::uint32_t at(int i) const { return i < 0 ? 0 : tour_[static_cast<std::size_t>(i)]; }
  double edge(std::uint32_t a, int next) const {
    if (next < static_cast<int>(tour_.size())) return cost(a, at(next));
    return problem_.meeting ? std::min(problem_.travel_s[a].back(), kFar_s) : 0;
  }

  void insert_cheapest(std::uint32_t node) {
    double best = std::numeric_limits<double>::infinity();
    int where = 0;
    for (int i = 0; i <= static_cast<int>(tour_.size()); ++i) {
      const double extra = cost(at(i - 1), node) + edge(node, i) - edge(at(i - 1), i);
      if (extra < best - kGain_s) {
        best = extra;
        where = i;
      }
    }
    tour_.insert(tour_.begin() + where, node);
  }

  /// 2-opt: the best reversal of a stretch [i, j], also right for unequal ways there and back.
  bool reverse_best() {
    const int n = static_cast<int>(tour_.size());
    double best = -kGain_s;
    int from = -1, to = -1;
    for (int i = 0; i < n; ++i) {
      double inside = 0;  // reversed minus forward
      for (int j = i + 1; j < n; ++j) {
        inside += cost(at(j), at(j - 1)) - cost(at(j - 1), at(j));
        const double change = cost(at(i - 1), at(j)) + edge(at(i), j + 1) - cost(at(i - 1), at(i)) -
                              edge(at(j), j + 1) + inside;
        if (change < best) {
          best = change;
          from = i;
          to = j;
        }
      }
    }
    if (from < 0) return false;
    std::reverse(tour_.begin() + from, tour_.begin() + to + 1);
    return true;
  }

  /// Or-opt: the best move of one to three neighbours to another place.
  bool move_best() {
    const int n = static_cast<int>(tour_.size());
    double best = -kGain_s;
    int from = -1, count = 0, to = -1;
    for (int length = 1; length <= 3; ++length) {
      for (int i = 0; i + length <= n; ++i) {
        const int last = i + length - 1;
        const double out =
            edge(at(i - 1), last + 1) - cost(at(i - 1), at(i)) - edge(at(last), last + 1);
        for (int j = 0; j <= n; ++j) {
          if (j >= i && j <= last + 1) continue;
          const double in = cost(at(j - 1), at(i)) + edge(at(last), j) - edge(at(j - 1), j);
          if (out + in < best) {
            best = out + in;
            from = i;
            count = length;
            to = j;
          }
        }
      }
    }
    if (from < 0) return false;
    const std::vector<std::uint32_t> piece(tour_.begin() + from, tour_.begin() + from + count);
    tour_.erase(tour_.begin() + from, tour_.begin() + from + count);
    tour_.insert(tour_.begin() + (to > from ? to - count : to), piece.begin(), piece.end());
    return true;
  }

  const OrderProblem& problem_;
  std::vector<std::uint32_t> tour_;
};

void validate(const OrderProblem& problem) {
  const std::size_t size = problem.gain.size() + 1 + (problem.meeting ? 1 : 0);
  MUSTER_CHECK(problem.travel_s.size() >= size);
  for (const auto& row : problem.travel_s) MUSTER_CHECK(row.size() == problem.travel_s.size());
}

}  // namespace

Order ff3e(const OrderProblem& problem, std::uint32_t nearest) {
  validate(problem);
  // Lines 14–17: only when there is time to spare on the way to the meeting.
  if (problem.meeting && problem.travel_s[0].back() >= problem.budget_s) {
    return finish(problem, {});
  }
  auto nodes = reachable_by_distance(problem);
  if (nodes.size() > nearest) nodes.resize(nearest);
  return finish(problem, LongestPath(problem, std::move(nodes)).solve());
}

Order shortest_order(const OrderProblem& problem) {
  validate(problem);
  return finish(problem, OpenTour(problem).solve(reachable_by_distance(problem)));
}

}  // namespace muster::route
