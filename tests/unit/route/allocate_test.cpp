#include "common/route/allocate.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <numeric>

#include "common/core/random.h"

using namespace muster;
using namespace muster::route;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
using Plans = std::vector<std::vector<std::uint32_t>>;

AllocationProblem random_allocation(Random& random, std::size_t robots, std::size_t areas) {
  struct Point {
    double x, y;
  };
  const auto draw = [&](std::size_t n) {
    std::vector<Point> points(n);
    for (auto& p : points) p = {random.uniform(0, 20), random.uniform(0, 20)};
    return points;
  };
  const auto from = draw(robots), at = draw(areas);
  const auto way = [](Point a, Point b) { return std::hypot(a.x - b.x, a.y - b.y); };
  AllocationProblem p;
  for (std::size_t k = 0; k < robots; ++k) {
    p.free_at_s.push_back(random.uniform(0, 15));
    p.first_s.emplace_back();
    for (const auto& a : at) p.first_s[k].push_back(way(from[k], a));
  }
  for (const auto& a : at) {
    p.between_s.emplace_back();
    for (const auto& b : at) p.between_s.back().push_back(way(a, b));
    p.service_s.push_back(random.uniform(1, 4));
  }
  return p;
}

double finish(const AllocationProblem& p, std::size_t k, const std::vector<std::uint32_t>& plan) {
  double t = p.free_at_s[k];
  for (std::size_t i = 0; i < plan.size(); ++i) {
    t +=
        (i == 0 ? p.first_s[k][plan[0]] : p.between_s[plan[i - 1]][plan[i]]) + p.service_s[plan[i]];
  }
  return t;
}

double makespan(const AllocationProblem& p, const Plans& plans) {
  double worst = 0;
  for (std::size_t k = 0; k < plans.size(); ++k) {
    if (!plans[k].empty()) worst = std::max(worst, finish(p, k, plans[k]));
  }
  return worst;
}

/// Every order of the areas, cut into plans in every way.
double best_makespan(const AllocationProblem& p) {
  std::vector<std::uint32_t> order(p.service_s.size());
  std::iota(order.begin(), order.end(), 0);
  double best = kInf;
  const std::size_t robots = p.free_at_s.size();
  do {
    std::vector<std::size_t> cut(robots + 1, 0);
    const auto split = [&](auto&& self, std::size_t k, std::size_t from) -> void {
      if (k + 1 == robots) {
        Plans plans(robots);
        cut[robots] = order.size();
        for (std::size_t r = 0; r < robots; ++r) {
          plans[r].assign(order.begin() + std::ptrdiff_t(cut[r]),
                          order.begin() + std::ptrdiff_t(cut[r + 1]));
        }
        best = std::min(best, makespan(p, plans));
        return;
      }
      for (std::size_t to = from; to <= order.size(); ++to) {
        cut[k + 1] = to;
        self(self, k + 1, to);
      }
    };
    split(split, 0, 0);
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

}  // namespace

TEST_CASE("the allocation gives every area to one inspector and ends near the earliest possible") {
  Random random(1, RobotId{0}, "allocate");
  double found = 0, best = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const auto p = random_allocation(random, 1 + random.below(3), 1 + random.below(6));
    const auto plans = allocate(p);
    std::vector<std::uint32_t> given;
    for (const auto& plan : plans) given.insert(given.end(), plan.begin(), plan.end());
    std::sort(given.begin(), given.end());
    std::vector<std::uint32_t> all(p.service_s.size());
    std::iota(all.begin(), all.end(), 0);
    CHECK(given == all);
    const double optimum = best_makespan(p);
    CHECK(makespan(p, plans) >= optimum - 1e-9);
    found += makespan(p, plans);
    best += optimum;
  }
  CHECK(found <= 1.03 * best);
}

TEST_CASE("an inspector that is busy for long gets nothing") {
  Random random(2, RobotId{0}, "allocate");
  auto p = random_allocation(random, 3, 6);
  p.free_at_s = {0, 1000, 0};
  CHECK(allocate(p)[1].empty());
}

TEST_CASE("an area nobody can get to is left out, and nobody to allocate to is no error") {
  Random random(3, RobotId{0}, "allocate");
  auto p = random_allocation(random, 2, 4);
  for (auto& row : p.first_s) row[2] = kInf;
  for (auto& row : p.between_s) row[2] = kInf;
  std::size_t given = 0;
  for (const auto& plan : allocate(p)) {
    given += plan.size();
    CHECK(std::find(plan.begin(), plan.end(), 2u) == plan.end());
  }
  CHECK(given == 3);
  AllocationProblem nobody;
  nobody.service_s = {1};
  nobody.between_s = {{0}};
  CHECK(allocate(nobody).empty());
}
