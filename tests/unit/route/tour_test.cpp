#include "common/route/tour.h"

#include <rapidcheck.h>

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
using Order = std::vector<std::uint32_t>;

/// Some windows hard, some soft; ways there and back differ; with and without an end.
TourProblem random_problem(Random& random, std::size_t stops) {
  TourProblem p;
  p.now_s = random.uniform(0, 50);
  p.wait_weight = random.chance(0.5) ? static_cast<double>(random.below(2)) : random.uniform();
  const bool end = random.chance(0.5);
  const std::size_t places = stops + (end ? 2 : 1);
  p.travel_s.assign(places, std::vector<double>(places, 0));
  for (auto& row : p.travel_s) {
    for (double& t : row) t = random.uniform(2, 30);
  }
  const double hard = random.uniform();
  const auto stop = [&] {
    Stop s{.from_s = p.now_s + random.uniform(-20, 100), .service_s = random.uniform(0, 5)};
    s.until_s = s.from_s + random.uniform(0, 60);
    s.late_weight = random.chance(hard) ? kNeverLate : random.uniform(0.2, 12);
    return s;
  };
  for (std::size_t s = 0; s < stops; ++s) p.stops.push_back(stop());
  if (end) {
    p.end = stop();
    p.end->until_s += 100;
  }
  return p;
}

struct Outcome {
  double cost = 0, travel_s = 0, wait_s = 0, late_s = 0;
};

/// As the header says it; infinite when a hard window is missed.
Outcome outcome(const TourProblem& p, const Order& order) {
  Outcome o;
  double t = p.now_s, late_cost = 0;
  std::size_t at = 0;
  const auto go = [&](const Stop& s, std::size_t place) {
    const double way = p.travel_s[at][place], arrive = t + way;
    const double wait = std::max(0.0, s.from_s - arrive);
    const double late = std::max(0.0, arrive - s.until_s);
    o.travel_s += way;
    o.wait_s += wait;
    if (s.late_weight != kNeverLate) o.late_s += late;
    if (late > 0) late_cost += s.late_weight * late;
    t = arrive + wait + s.service_s;
    at = place;
  };
  for (const auto s : order) go(p.stops[s], s + 1);
  if (p.end) go(*p.end, p.stops.size() + 1);
  o.cost = o.travel_s + p.wait_weight * o.wait_s + late_cost;
  return o;
}

Order first_order(std::size_t n) {
  Order order(n);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

double least_cost(const TourProblem& p) {
  Order order = first_order(p.stops.size());
  double least = kInf;
  do least = std::min(least, outcome(p, order).cost);
  while (std::next_permutation(order.begin(), order.end()));
  return least;
}

/// Meetings at random places, open one after the other.
TourProblem meetings(Random& random, std::size_t n) {
  TourProblem p;
  p.wait_weight = 1;
  std::vector<std::pair<double, double>> at;
  for (std::size_t i = 0; i <= n; ++i)
    at.emplace_back(random.uniform(0, 120), random.uniform(0, 120));
  for (const auto& a : at) {
    auto& row = p.travel_s.emplace_back();
    for (const auto& b : at) row.push_back(std::hypot(a.first - b.first, a.second - b.second));
  }
  for (std::size_t m = 0; m < n; ++m) {
    const double from = random.uniform(0, 40.0 * static_cast<double>(n));
    p.stops.push_back({from, from + 30, 2, 10});
  }
  return p;
}

}  // namespace

TEST_CASE("a tour over few stops costs what the best of all orders costs, hard and soft") {
  const auto whatever = [] {
    const auto seed = *rc::gen::arbitrary<std::uint32_t>();
    Random random(seed, RobotId{0}, "tour");
    const TourProblem p = random_problem(random, random.below(7));
    const double least = least_cost(p);
    const auto tour = plan_tour(p);
    RC_ASSERT(tour.has_value() == (least < kInf));
    if (!tour) return;
    Order sorted = tour->order;
    std::sort(sorted.begin(), sorted.end());
    RC_ASSERT(sorted == first_order(p.stops.size()));
    const Outcome o = outcome(p, tour->order);
    const auto near = [](double a, double b) { return std::abs(a - b) < 1e-6; };
    RC_ASSERT(near(tour->cost, least));
    RC_ASSERT(near(tour->cost, o.cost) && near(tour->bound, least));
    RC_ASSERT(near(tour->travel_s, o.travel_s) && near(tour->wait_s, o.wait_s));
    RC_ASSERT(near(tour->late_s, o.late_s));
    RC_ASSERT(tour->arrive_s.size() == p.stops.size() + (p.end ? 1 : 0));
  };
  CHECK(rc::check("tours", whatever));
}

TEST_CASE("with work for a part only, what is said of the best tour still holds") {
  Random random(1, RobotId{0}, "tour");
  for (int trial = 0; trial < 3; ++trial) {
    TourProblem p = meetings(random, 16);
    p.max_labels = 20'000'000;
    const auto best = plan_tour(p);
    REQUIRE(best);
    CHECK(best->bound == Approx(best->cost));
    for (const std::uint64_t work : {2'000, 20'000, 60'000}) {
      p.max_labels = work;
      const auto tour = plan_tour(p);
      REQUIRE(tour);
      CHECK(tour->cost >= best->cost - 1e-9);
      CHECK(tour->bound <= best->cost + 1e-9);
    }
  }
}

TEST_CASE("many meetings are each held once, sooner than in the order of their windows") {
  Random random(5, RobotId{0}, "tour");
  for (int trial = 0; trial < 3; ++trial) {
    TourProblem p = meetings(random, 30);
    p.max_labels = 100'000;
    const auto tour = plan_tour(p);
    REQUIRE(tour);
    Order by_window = first_order(30), sorted = tour->order;
    std::sort(sorted.begin(), sorted.end());
    CHECK(sorted == by_window);
    std::sort(by_window.begin(), by_window.end(),
              [&](auto a, auto b) { return p.stops[a].until_s < p.stops[b].until_s; });
    CHECK(tour->cost < outcome(p, by_window).cost);
    CHECK(tour->bound <= tour->cost);
  }
}

TEST_CASE("a hard window that cannot be kept is no tour, a soft one is a late tour") {
  TourProblem p{.travel_s = {{0, 10}, {10, 0}}, .stops = {{0, 5}}};
  CHECK_FALSE(plan_tour(p));
  p.stops[0].late_weight = 3;
  CHECK(plan_tour(p)->cost == Approx(10 + 3 * 5));
  p.travel_s[0][1] = kInf;
  CHECK(plan_tour(p)->late_s > 1e6);
}

TEST_CASE("no stops: an empty tour, or the way to the end") {
  CHECK(plan_tour({.travel_s = {{0}}, .stops = {}})->order.empty());
  const auto home = plan_tour({.travel_s = {{0, 7}, {7, 0}}, .stops = {}, .end = Stop{}});
  CHECK(home->cost == 7);
  CHECK(home->arrive_s == std::vector<double>{7});
}
