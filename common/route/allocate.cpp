#include "common/route/allocate.h"

#include <algorithm>
#include <limits>

#include "common/core/error.h"

namespace muster::route {
namespace {

constexpr double kFar_s = 1e7;  ///< "no way", finite so that sums stay ordered
constexpr double kGain_s = 1e-9;
constexpr std::uint64_t kMaxEvaluations = 300'000;

using Plan = std::vector<std::uint32_t>;

struct Cost {
  double finish_s = 0, travel_s = 0;
};

/// The largest finishing time first, then the total travel.
struct TeamCost {
  double makespan_s = 0, travel_s = 0;
  bool better_than(const TeamCost& o) const {
    if (makespan_s < o.makespan_s - kGain_s) return true;
    return makespan_s < o.makespan_s + kGain_s && travel_s < o.travel_s - kGain_s;
  }
};

class Allocator {
 public:
  explicit Allocator(const AllocationProblem& problem)
      : problem_(problem), plans_(problem.free_at_s.size()), costs_(plans_.size()) {
    for (std::size_t k = 0; k < plans_.size(); ++k) costs_[k] = cost(k, plans_[k]);
  }

  std::vector<Plan> solve() {
    insert_all();
    while (evaluations_ < kMaxEvaluations && (relocate() || swap() || turn())) {
    }
    return plans_;
  }

 private:
  Cost cost(std::size_t k, const Plan& plan) {
    ++evaluations_;
    Cost c{problem_.free_at_s[k], 0};
    for (std::size_t i = 0; i < plan.size(); ++i) {
      const double way =
          i == 0 ? problem_.first_s[k][plan[0]] : problem_.between_s[plan[i - 1]][plan[i]];
      c.travel_s += std::min(way, kFar_s);
      c.finish_s += std::min(way, kFar_s) + problem_.service_s[plan[i]];
    }
    return c;
  }

  TeamCost team(std::size_t a, const Cost& in_a, std::size_t b, const Cost& in_b) const {
    TeamCost t;
    for (std::size_t k = 0; k < plans_.size(); ++k) {
      const Cost& c = k == a ? in_a : k == b ? in_b : costs_[k];
      // Who gets nothing is done already; its old plan must not hide what the others could save.
      const bool idle = k != a && k != b && plans_[k].empty();
      if (!idle) t.makespan_s = std::max(t.makespan_s, c.finish_s);
      t.travel_s += c.travel_s;
    }
    return t;
  }
  TeamCost team() const {
    constexpr auto kNobody = std::numeric_limits<std::size_t>::max();
    return team(kNobody, {}, kNobody, {});
  }

  struct Insertion {
    double finish_s = std::numeric_limits<double>::infinity();
    std::size_t robot = 0, where = 0;
  };
  Insertion best_insertion(std::size_t k, std::uint32_t area) {
    Insertion best;
    best.robot = k;
    Plan plan = plans_[k];
    for (std::size_t i = 0; i <= plans_[k].size(); ++i) {
      plan.insert(plan.begin() + static_cast<std::ptrdiff_t>(i), area);
      const double finish = cost(k, plan).finish_s;
      if (finish < best.finish_s - kGain_s) {
        best.finish_s = finish;
        best.where = i;
      }
      plan.erase(plan.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return best;
  }

  /// Regret: first the area that would suffer most if its best inspector were taken by another.
  void insert_all() {
    std::vector<std::uint32_t> open;
    for (std::uint32_t area = 0; area < problem_.service_s.size(); ++area) {
      const auto has_way = [&](const auto& row) { return row[area] < kFar_s; };
      if (std::any_of(problem_.first_s.begin(), problem_.first_s.end(), has_way)) {
        open.push_back(area);
      }
    }
    // Insertions into a plan change only when that plan does.
    std::vector<std::vector<Insertion>> table(open.size());
    for (std::size_t i = 0; i < open.size(); ++i) {
      for (std::size_t k = 0; k < plans_.size(); ++k) {
        table[i].push_back(best_insertion(k, open[i]));
      }
    }
    while (!open.empty()) {
      std::size_t pick = 0;
      Insertion picked;
      double most_regret = -1;
      for (std::size_t i = 0; i < open.size(); ++i) {
        Insertion first, second;
        for (const Insertion& candidate : table[i]) {
          if (candidate.finish_s < first.finish_s - kGain_s) {
            second = first;
            first = candidate;
          } else if (candidate.finish_s < second.finish_s) {
            second = candidate;
          }
        }
        const double regret = std::min(second.finish_s, 2 * kFar_s) - first.finish_s;
        if (regret > most_regret + kGain_s ||
            (regret > most_regret - kGain_s && first.finish_s < picked.finish_s - kGain_s)) {
          most_regret = std::max(regret, most_regret);
          pick = i;
          picked = first;
        }
      }
      Plan& plan = plans_[picked.robot];
      plan.insert(plan.begin() + static_cast<std::ptrdiff_t>(picked.where), open[pick]);
      costs_[picked.robot] = cost(picked.robot, plan);
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(pick));
      table.erase(table.begin() + static_cast<std::ptrdiff_t>(pick));
      for (std::size_t i = 0; i < open.size(); ++i) {
        table[i][picked.robot] = best_insertion(picked.robot, open[i]);
      }
    }
  }

  bool accept(std::size_t a, Plan plan_a, std::size_t b, Plan plan_b, const TeamCost& now) {
    const Cost cost_a = cost(a, plan_a), cost_b = a == b ? cost_a : cost(b, plan_b);
    if (!team(a, cost_a, b, cost_b).better_than(now)) return false;
    plans_[a] = std::move(plan_a);
    costs_[a] = cost_a;
    if (a != b) {
      plans_[b] = std::move(plan_b);
      costs_[b] = cost_b;
    }
    return true;
  }

  bool relocate() {
    const TeamCost now = team();
    for (std::size_t a = 0; a < plans_.size(); ++a) {
      for (std::size_t i = 0; i < plans_[a].size(); ++i) {
        for (std::size_t b = 0; b < plans_.size(); ++b) {
          Plan from = plans_[a];
          const auto area = from[i];
          from.erase(from.begin() + static_cast<std::ptrdiff_t>(i));
          const std::size_t places = (a == b ? from : plans_[b]).size() + 1;
          for (std::size_t j = 0; j < places; ++j) {
            if (evaluations_ >= kMaxEvaluations) return false;
            Plan into = a == b ? from : plans_[b];
            into.insert(into.begin() + static_cast<std::ptrdiff_t>(j), area);
            if (a == b ? accept(a, into, a, {}, now) : accept(a, from, b, into, now)) return true;
          }
        }
      }
    }
    return false;
  }

  bool swap() {
    const TeamCost now = team();
    for (std::size_t a = 0; a < plans_.size(); ++a) {
      for (std::size_t b = a; b < plans_.size(); ++b) {
        for (std::size_t i = 0; i < plans_[a].size(); ++i) {
          for (std::size_t j = a == b ? i + 1 : 0; j < plans_[b].size(); ++j) {
            if (evaluations_ >= kMaxEvaluations) return false;
            Plan in_a = plans_[a], in_b = plans_[b];
            std::swap(in_a[i], a == b ? in_a[j] : in_b[j]);
            if (accept(a, in_a, b, in_b, now)) return true;
          }
        }
      }
    }
    return false;
  }

  /// 2-opt inside one plan.
  bool turn() {
    const TeamCost now = team();
    for (std::size_t a = 0; a < plans_.size(); ++a) {
      for (std::size_t i = 0; i < plans_[a].size(); ++i) {
        for (std::size_t j = i + 2; j < plans_[a].size(); ++j) {
          if (evaluations_ >= kMaxEvaluations) return false;
          Plan turned = plans_[a];
          std::reverse(turned.begin() + static_cast<std::ptrdiff_t>(i),
                       turned.begin() + static_cast<std::ptrdiff_t>(j) + 1);
          if (accept(a, turned, a, {}, now)) return true;
        }
      }
    }
    return false;
  }

  const AllocationProblem& problem_;
  std::vector<Plan> plans_;
  std::vector<Cost> costs_;
  std::uint64_t evaluations_ = 0;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> allocate(const AllocationProblem& problem) {
  const std::size_t robots = problem.free_at_s.size(), areas = problem.service_s.size();
  MUSTER_CHECK(problem.first_s.size() == robots && problem.between_s.size() == areas);
  for (const auto& row : problem.first_s) MUSTER_CHECK(row.size() == areas);
  if (robots == 0) return {};
  return Allocator(problem).solve();
}

}  // namespace muster::route
