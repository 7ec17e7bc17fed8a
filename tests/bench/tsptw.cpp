// The station's tour on the literature's instances of the travelling salesman's problem with time
// windows (Dumas et al. 1995; objective: sum of travel times, windows hard, waiting free), against
// the best known values. Prints a table; status 1 when a window is violated, an instance of up to
// 60 places is above its best known value, or one of 80 more than 1 % above.
//
//     build/tests/tsptw ../shared/benchmarks/tsptw_dumas > tests/bench/tsptw_dumas.txt
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "common/route/tour.h"

namespace {

using muster::route::plan_tour;
using muster::route::Stop;
using muster::route::Tour;
using muster::route::TourProblem;
namespace fs = std::filesystem;

constexpr int kSkipped = 77;
constexpr std::size_t kExactUpTo = 60;
constexpr double kGap = 0.01;

/// Places, the matrix of ways, a window per place. The first place is the depot: the tour begins
/// there at 0 and comes back within its window.
TourProblem read(const fs::path& file) {
  std::ifstream in(file);
  std::size_t n = 0;
  in >> n;
  TourProblem p;
  p.travel_s.assign(n + 1, std::vector<double>(n + 1, 0));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) in >> p.travel_s[i][j];
  }
  for (std::size_t i = 0; i < n; ++i) {
    p.travel_s[n][i] = p.travel_s[0][i];
    p.travel_s[i][n] = p.travel_s[i][0];
  }
  Stop depot;
  in >> depot.from_s >> depot.until_s;
  p.end = depot;
  for (std::size_t i = 1; i < n; ++i) {
    Stop& stop = p.stops.emplace_back();
    in >> stop.from_s >> stop.until_s;
  }
  if (!in) {
    std::fprintf(stderr, "%s: not an instance: places, ways, windows\n", file.c_str());
    std::exit(2);
  }
  return p;
}

/// Driven again by what the file says alone: every place once, no window violated.
bool keeps_windows(const TourProblem& p, const Tour& tour) {
  std::vector<bool> seen(p.stops.size(), false);
  double t = 0;
  std::size_t at = 0;
  for (const std::uint32_t s : tour.order) {
    if (seen[s]) return false;
    seen[s] = true;
    t = std::max(t + p.travel_s[at][s + 1], p.stops[s].from_s);
    if (t > p.stops[s].until_s) return false;
    at = s + 1;
  }
  return tour.order.size() == p.stops.size() && t + p.travel_s[at].back() <= p.end->until_s;
}

struct Known {
  std::string name;
  double cost = 0;
};
std::vector<Known> best_known(const fs::path& file) {
  std::vector<Known> all;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    Known k;
    if (words >> k.name >> k.cost) all.push_back(k);
  }
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path folder = argc > 1 ? argv[1] : "../shared/benchmarks/tsptw_dumas";
  const auto known = best_known(folder / "best_known.txt");
  if (known.empty()) {
    std::printf("skipped: no instances in %s\n", folder.c_str());
    return kSkipped;
  }
  std::printf("%-17s %6s %10s %6s %8s %7s %8s\n", "instance", "places", "best known", "ours",
              "gap %", "proven", "CPU ms");
  int missed = 0;
  for (const Known& k : known) {
    const TourProblem p = read(folder / k.name);
    const std::clock_t begin = std::clock();
    const auto tour = plan_tour(p);
    const double cpu_ms = 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    const bool kept = tour && keeps_windows(p, *tour);
    const double gap = tour ? tour->cost / k.cost - 1 : INFINITY;
    const std::size_t places = p.stops.size();
    const bool good = kept && gap > -1e-9 && gap <= (places <= kExactUpTo ? 1e-9 : kGap);
    missed += good ? 0 : 1;
    std::printf("%-17s %6zu %10g %6g %8.2f %7s %8.0f%s\n", k.name.c_str(), places, k.cost,
                tour ? tour->cost : INFINITY, 100 * gap,
                tour && tour->bound >= tour->cost - 1e-6 ? "yes" : "no", cpu_ms,
                kept ? (good ? "" : "  MISSED") : "  WINDOWS VIOLATED");
  }
  std::printf("%zu instances, %d missed\n", known.size(), missed);
  return missed == 0 ? 0 : 1;
}
