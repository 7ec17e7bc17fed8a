#include "common/route/explore_order.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/core/random.h"

using namespace muster;
using namespace muster::route;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

OrderProblem random_problem(Random& random, std::uint32_t viewpoints, bool meeting) {
  OrderProblem p;
  p.meeting = meeting;
  const std::size_t n = viewpoints + 1 + (meeting ? 1 : 0);
  p.travel_s.assign(n, std::vector<double>(n, 0));
  for (auto& row : p.travel_s) {
    for (double& t : row) t = random.uniform(1, 10);
  }
  p.gain.assign(viewpoints, 1);
  p.budget_s = kInf;
  return p;
}

/// Places in a plane: no detour is shorter than the direct way, as between real places.
OrderProblem random_places(Random& random, std::uint32_t viewpoints) {
  auto p = random_problem(random, viewpoints, true);
  std::vector<std::pair<double, double>> at(p.travel_s.size());
  for (auto& [x, y] : at) x = random.uniform(0, 10), y = random.uniform(0, 10);
  for (std::size_t i = 0; i < at.size(); ++i) {
    for (std::size_t j = 0; j < at.size(); ++j) {
      p.travel_s[i][j] = std::hypot(at[i].first - at[j].first, at[i].second - at[j].second);
    }
  }
  return p;
}

double length(const OrderProblem& p, const std::vector<std::uint32_t>& visit, bool to_meeting) {
  double sum = 0;
  std::uint32_t at = 0;
  for (const auto v : visit) {
    sum += p.travel_s[at][v + 1];
    at = v + 1;
  }
  return sum + (to_meeting && p.meeting ? p.travel_s[at].back() : 0);
}

/// The longest path of any prefix of any order that still makes the meeting.
double longest_by_trial(const OrderProblem& p) {
  std::vector<std::uint32_t> order(p.gain.size());
  std::iota(order.begin(), order.end(), 0);
  double best = 0;
  do {
    for (std::size_t k = 0; k <= order.size(); ++k) {
      const std::vector<std::uint32_t> prefix(order.begin(), order.begin() + std::ptrdiff_t(k));
      if (length(p, prefix, true) <= p.budget_s) best = std::max(best, length(p, prefix, false));
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

}  // namespace

TEST_CASE("FF3E finds the longest path that still makes the meeting") {
  Random random(1, RobotId{0}, "ff3e");
  for (int trial = 0; trial < 60; ++trial) {
    auto p = random_places(random, 1 + static_cast<std::uint32_t>(random.below(6)));
    p.budget_s = random.uniform(1, 40);
    const Order order = ff3e(p);
    CHECK(length(p, order.visit, false) == Approx(longest_by_trial(p)));
    CHECK(order.length_s == Approx(length(p, order.visit, true)));
    if (!order.visit.empty()) CHECK(order.length_s <= p.budget_s);
  }
}

TEST_CASE("FF3E goes straight to a meeting it is late for") {
  Random random(2, RobotId{0}, "ff3e");
  auto p = random_problem(random, 5, true);
  p.budget_s = p.travel_s[0].back();
  CHECK(ff3e(p).visit.empty());
  CHECK(ff3e(p).length_s == Approx(p.travel_s[0].back()));
}

TEST_CASE("FF3E orders only the nearest viewpoints and never an unreachable one") {
  Random random(3, RobotId{0}, "ff3e");
  auto p = random_problem(random, 30, true);
  p.travel_s[0][4] = kInf;
  for (auto& row : p.travel_s) row[4] = kInf;
  const Order order = ff3e(p, 7);
  CHECK(order.visit.size() == 7);
  CHECK(std::find(order.visit.begin(), order.visit.end(), 3u) == order.visit.end());
  std::vector<double> all(p.travel_s[0].begin() + 1, p.travel_s[0].end() - 1);
  std::sort(all.begin(), all.end());
  for (const auto v : order.visit) CHECK(p.travel_s[0][v + 1] <= all[6]);
}

TEST_CASE("the short tour visits every reachable viewpoint once and is near the shortest") {
  Random random(4, RobotId{0}, "tour");
  double found = 0, shortest = 0;
  for (int trial = 0; trial < 60; ++trial) {
    auto p = random_problem(random, 2 + static_cast<std::uint32_t>(random.below(5)), trial % 2);
    const Order order = shortest_order(p);
    auto sorted = order.visit;
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::uint32_t> all(p.gain.size());
    std::iota(all.begin(), all.end(), 0);
    CHECK(sorted == all);
    CHECK(order.length_s == Approx(length(p, order.visit, true)));
    double best = kInf;
    do best = std::min(best, length(p, all, true));
    while (std::next_permutation(all.begin(), all.end()));
    CHECK(order.length_s >= best - 1e-9);
    found += order.length_s;
    shortest += best;
  }
  CHECK(found <= 1.03 * shortest);
}

TEST_CASE("an order of no viewpoints is the way to the meeting") {
  OrderProblem p;
  p.meeting = true;
  p.travel_s = {{0, 5}, {5, 0}};
  p.budget_s = 100;
  CHECK(ff3e(p).length_s == 5);
  CHECK(shortest_order(p).length_s == 5);
  p.meeting = false;
  p.travel_s = {{0}};
  CHECK(shortest_order(p).length_s == 0);
}
