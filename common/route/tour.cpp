#include <algorithm>
#include <limits>

#include "common/core/error.h"
#include "common/route/allocate.h"

namespace muster::route {
namespace {

constexpr double kFar_s = 1e7;
constexpr double kGain = 1e-9;
constexpr std::size_t kExact = 12;
constexpr std::size_t kMaxLabels = 64;

/// How a tour stands after some meetings. Travel and waiting together are `free_at` − now −
/// service, so that time and lateness say all.
struct Label {
  double free_at_s = 0, late_s = 0;
  std::uint32_t parent_last = 0,
                parent = 0;  ///< the state one meeting earlier, and which of its labels
  bool dominates(const Label& o) const {
    return free_at_s <= o.free_at_s + kGain && late_s <= o.late_s + kGain;
  }
};

/// Drives from node `from` (0: the start) to meeting `m`, waits for its window, meets.
Label drive(const TourProblem& p, const Label& label, std::uint32_t from, std::uint32_t m) {
  Label next;
  const double arrive = label.free_at_s + std::min(p.travel_s[from][m + 1], kFar_s);
  next.late_s = label.late_s + std::max(0.0, arrive - p.until_s[m]);
  next.free_at_s = std::max(arrive, p.from_s[m]) + p.service_s;
  return next;
}

double cost_of(const TourProblem& p, const Label& label, std::size_t meetings) {
  return label.free_at_s - p.now_s - p.service_s * static_cast<double>(meetings) +
         p.late_weight * label.late_s;
}

Label along(const TourProblem& p, const std::vector<std::uint32_t>& order) {
  Label label;
  label.free_at_s = p.now_s;
  std::uint32_t at = 0;
  for (const auto m : order) {
    label = drive(p, label, at, m);
    at = m + 1;
  }
  return label;
}

Tour finish(const TourProblem& p, std::vector<std::uint32_t> order) {
  Tour tour;
  Label label;
  label.free_at_s = p.now_s;
  std::uint32_t at = 0;
  for (const auto m : order) {
    tour.arrive_s.push_back(label.free_at_s + std::min(p.travel_s[at][m + 1], kFar_s));
    label = drive(p, label, at, m);
    at = m + 1;
  }
  tour.cost = cost_of(p, label, order.size());
  tour.order = std::move(order);
  return tour;
}

/// Dynamic programming over (set of meetings held, last one) with the labels that nothing
/// dominates: early but late for somebody, or late for nobody but slower.
std::vector<std::uint32_t> exact(const TourProblem& p, std::uint32_t n) {
  const std::uint32_t sets = 1u << n;
  std::vector<std::vector<Label>> table(static_cast<std::size_t>(sets) * n);
  const auto state = [&](std::uint32_t set, std::uint32_t last) -> std::vector<Label>& {
    return table[static_cast<std::size_t>(set) * n + last];
  };
  const auto offer = [&](std::vector<Label>& labels, const Label& label) {
    for (const Label& other : labels) {
      if (other.dominates(label)) return;
    }
    std::erase_if(labels, [&](const Label& other) { return label.dominates(other); });
    if (labels.size() < kMaxLabels) labels.push_back(label);
  };

  Label start;
  start.free_at_s = p.now_s;
  for (std::uint32_t m = 0; m < n; ++m) state(1u << m, m).push_back(drive(p, start, 0, m));
  for (std::uint32_t set = 1; set < sets; ++set) {
    for (std::uint32_t last = 0; last < n; ++last) {
      // Complete by now: only smaller sets, which come first, lead here. So indices of labels are
      // stable.
      const auto& labels = state(set, last);
      for (std::uint32_t i = 0; i < labels.size(); ++i) {
        for (std::uint32_t m = 0; m < n; ++m) {
          if (set & (1u << m)) continue;
          Label next = drive(p, labels[i], last + 1, m);
          next.parent = i;
          next.parent_last = last;
          offer(state(set | (1u << m), m), next);
        }
      }
    }
  }

  const std::uint32_t all = sets - 1;
  double best = std::numeric_limits<double>::infinity();
  std::uint32_t last = 0, index = 0;
  for (std::uint32_t m = 0; m < n; ++m) {
    const auto& labels = state(all, m);
    for (std::uint32_t i = 0; i < labels.size(); ++i) {
      const double cost = cost_of(p, labels[i], n);
      if (cost < best - kGain) {
        best = cost;
        last = m;
        index = i;
      }
    }
  }
  std::vector<std::uint32_t> order;
  for (std::uint32_t set = all;;) {
    order.push_back(last);
    const Label label = state(set, last)[index];
    set &= ~(1u << last);
    if (set == 0) break;
    last = label.parent_last;
    index = label.parent;
  }
  std::reverse(order.begin(), order.end());
  return order;
}

/// Cheapest insertion by closing time, then moves and reversals until none helps or the count is
/// used up.
std::vector<std::uint32_t> heuristic(const TourProblem& p, std::uint32_t n) {
  std::vector<std::uint32_t> by_deadline(n), order;
  for (std::uint32_t m = 0; m < n; ++m) by_deadline[m] = m;
  std::stable_sort(by_deadline.begin(), by_deadline.end(),
                   [&](auto a, auto b) { return p.until_s[a] < p.until_s[b]; });
  const auto cost = [&](const auto& o) { return cost_of(p, along(p, o), o.size()); };
  for (const auto m : by_deadline) {
    std::vector<std::uint32_t> best_order;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i <= order.size(); ++i) {
      auto candidate = order;
      candidate.insert(candidate.begin() + static_cast<std::ptrdiff_t>(i), m);
      const double c = cost(candidate);
      if (c < best - kGain) {
        best = c;
        best_order = std::move(candidate);
      }
    }
    order = std::move(best_order);
  }

  constexpr int kMaxPasses = 50;
  double now = cost(order);
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    auto best_order = order;
    double best = now;
    const auto consider = [&](const auto& candidate) {
      const double c = cost(candidate);
      if (c < best - kGain) {
        best = c;
        best_order = candidate;
      }
    };
    for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(n); ++i) {
      for (std::ptrdiff_t j = 0; j < static_cast<std::ptrdiff_t>(n); ++j) {
        if (i == j) continue;
        auto moved = order;
        moved.erase(moved.begin() + i);
        moved.insert(moved.begin() + j, order[static_cast<std::size_t>(i)]);
        consider(moved);
        if (j <= i) continue;
        auto turned = order;
        std::reverse(turned.begin() + i, turned.begin() + j + 1);
        consider(turned);
      }
    }
    if (best >= now - kGain) break;
    now = best;
    order = std::move(best_order);
  }
  return order;
}

}  // namespace

Tour plan_tour(const TourProblem& problem) {
  const std::size_t n = problem.from_s.size();
  MUSTER_CHECK(problem.until_s.size() == n && problem.travel_s.size() == n + 1);
  if (n == 0) return {};
  const auto count = static_cast<std::uint32_t>(n);
  return finish(problem, n <= kExact ? exact(problem, count) : heuristic(problem, count));
}

std::vector<std::uint32_t> share_inspectors(std::uint32_t inspectors,
                                            const std::vector<double>& volumes_m3) {
  const std::size_t n = volumes_m3.size();
  std::vector<std::uint32_t> share(n, 0);
  if (n == 0) return share;
  double total = 0;
  for (const double v : volumes_m3) total += std::max(v, 0.0);

  std::vector<double> quota(n);
  std::uint32_t left = inspectors;
  for (std::size_t i = 0; i < n; ++i) {
    const double part = total > 0 ? std::max(volumes_m3[i], 0.0) / total : 1.0 / double(n);
    quota[i] = part * inspectors;
    share[i] = std::min(left, static_cast<std::uint32_t>(quota[i] + kGain));  // floor, as in (14)
    left -= share[i];
  }
  // (14) alone leaves inspectors over: they go to the largest remainders.
  std::vector<std::size_t> by_remainder(n);
  for (std::size_t i = 0; i < n; ++i) by_remainder[i] = i;
  std::stable_sort(by_remainder.begin(), by_remainder.end(), [&](auto a, auto b) {
    return quota[a] - share[a] > quota[b] - share[b] + kGain;
  });
  for (std::size_t i = 0; left > 0; i = (i + 1) % n, --left) ++share[by_remainder[i]];

  // A region without an inspector takes one from the region that has most above its quota.
  for (std::size_t i = 0; i < n; ++i) {
    if (share[i] > 0) continue;
    std::size_t giver = n;
    for (std::size_t j = 0; j < n; ++j) {
      if (share[j] < 2) continue;
      if (giver == n || share[j] - quota[j] > share[giver] - quota[giver] + kGain) giver = j;
    }
    if (giver == n) break;
    --share[giver];
    ++share[i];
  }
  return share;
}

}  // namespace muster::route
