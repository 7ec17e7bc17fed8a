#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>

#include "tests/unit/store/air.h"

using namespace muster;
using namespace muster::store;
namespace fs = std::filesystem;

namespace {

RobotId id(std::uint32_t i) { return RobotId{i}; }

/// What has to hold after any weather.
struct Verdict {
  bool converged = false;       ///< who can reach each other holds the same
  bool true_to_digest = true;   ///< no store's digest says more than it holds
  bool promises_kept = false;   ///< no disk lacks what its robot ever said that it holds
  bool numbers_unique = false;  ///< no number was given to two records
  bool good() const { return converged && true_to_digest && promises_kept && numbers_unique; }
};

/// Some seconds of bad weather: what is likely to happen in a tick.
struct Climate {
  explicit Climate(Random& random)
      : write(random.uniform(0.02, 0.5)),
        link(random.uniform(0.01, 0.3)),
        kill(random.chance(0.6) ? random.uniform(0, 0.02) : 0),
        revive(random.uniform(0.02, 0.3)) {}
  double write, link, kill, revive;
};

class Storm {
 public:
  Storm(std::uint64_t seed, const Air::Setup& setup)
      : random_(seed, kNoRobot, "storm"),
        robots_(static_cast<std::uint32_t>(2 + random_.below(4))),
        air_(seed, robots_, setup),
        climate_(random_) {
    if (random_.chance(0.7)) air_.weather.loss = random_.uniform(0, 0.6);
    if (random_.chance(0.5)) air_.weather.repeat = random_.uniform(0, 0.3);
    if (random_.chance(0.5)) air_.weather.delay = random_.uniform(0, 0.3);
    air_.weather.budget = random_.chance(0.3) ? 150 : 256 * 1024;
    if (random_.chance(0.5)) air_.link_all();
  }

  Verdict blow() {
    Verdict verdict;
    for (int t = 0; t < 60; ++t) {
      for (std::uint32_t i = 0; i < robots_; ++i) {
        if (air_.alive(id(i)))
          live(id(i));
        else if (random_.chance(climate_.revive))
          revive(id(i));
      }
      air_.tick();
      if (t % 10 == 0) verdict.true_to_digest &= air_.digests_are_true();
    }
    clear_up();
    verdict.converged = converges();
    verdict.true_to_digest &= air_.digests_are_true();
    verdict.numbers_unique = air_.numbers_are_unique();
    verdict.promises_kept = air_.promises_are_kept();
    return verdict;
  }

 private:
  void live(RobotId robot) {
    if (random_.chance(climate_.write)) {
      constexpr RecordClass kClasses[] = {RecordClass::kInspection, RecordClass::kPlan,
                                          RecordClass::kMap, RecordClass::kImage};
      const RecordClass cls = kClasses[random_.below(4)];
      // Large enough to be only on disk once it is there.
      air_.write(robot, cls, random_.below(4), cls == RecordClass::kImage ? 1100 : 40);
    }
    if (random_.chance(climate_.link)) {
      const RobotId other = id(static_cast<std::uint32_t>(random_.below(robots_)));
      const bool up = random_.chance(0.5);
      if (other == robot) return;
      if (random_.chance(0.2))
        air_.link_one_way(robot, other, up);
      else
        air_.link(robot, other, up);
    }
    if (random_.chance(climate_.kill))
      air_.kill_at(robot, static_cast<Air::Killed>(1 + random_.below(3)));
  }

  void revive(RobotId robot) {
    if (random_.chance(0.6))
      air_.start_with_disk(robot, random_.chance(0.5));
    else if (random_.chance(0.6))
      air_.start_empty(robot);
    else
      air_.start_behind(robot);
  }

  /// A fair sky: some of the dead come back, and who lives is connected, in a chain at least.
  void clear_up() {
    air_.weather.loss = air_.weather.repeat = air_.weather.delay = 0;
    air_.cut_one_way_links();
    for (std::uint32_t i = 0; i < robots_; ++i) {
      if (!air_.alive(id(i)) && (air_.living().empty() || random_.chance(0.5))) revive(id(i));
    }
    const auto living = air_.living();
    for (std::size_t i = 1; i < living.size(); ++i) air_.link(living[i - 1], living[i], true);
  }

  bool converges() {
    for (int t = 0; t < 300; ++t) {
      if (air_.all_equal() && air_.all_caught_up()) return true;
      air_.tick();
    }
    return false;
  }

  Random random_;
  std::uint32_t robots_;
  Air air_;
  Climate climate_;
};

/// The storms of seeds first … last; how many of them did harm.
int harmful(std::uint64_t first, std::uint64_t last, const Air::Setup& setup) {
  int harm = 0;
  for (std::uint64_t seed = first; seed <= last; ++seed) harm += !Storm(seed, setup).blow().good();
  return harm;
}

void survive(std::uint64_t first, std::uint64_t last, const Air::Setup& setup = {}) {
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    const Verdict verdict = Storm(seed, setup).blow();
    CAPTURE(seed);
    if (verdict.good()) continue;
    CHECK(verdict.converged);
    CHECK(verdict.true_to_digest);
    CHECK(verdict.promises_kept);
    CHECK(verdict.numbers_unique);
    FAIL("a storm did harm");
  }
  SUCCEED();
}

}  // namespace

TEST_CASE("no storm of 10 000 takes a record that was acknowledged, or keeps stores apart") {
  survive(1, 10'000);
}

TEST_CASE("storms over real journals, each killed again and again, do no harm either") {
  // In memory where there is such a place: what a slow disk does is not what is looked at.
  const fs::path root = fs::is_directory("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
  const fs::path dir = root / ("muster_storm_" + std::to_string(getpid()));
  fs::create_directories(dir);
  survive(20'001, 20'300, {.files = dir.string()});
  fs::remove_all(dir);
}

TEST_CASE("the same storms catch a digest of a single number") {
  const int harm = harmful(1, 200, {.single_number = true});
  std::printf("a digest of a single number: %d of 200 storms did harm\n", harm);
  CHECK(harm > 0);
}

TEST_CASE("the same storms catch a merge that forgets whose start a number is of") {
  const int harm =
      harmful(1, 200, {.supersedes = [](const RecordHeader& fresh, const RecordHeader& held) {
                return fresh.seq > held.seq;
              }});
  std::printf("a merge by number alone: %d of 200 storms did harm\n", harm);
  CHECK(harm > 0);
}

TEST_CASE("the same storms catch a merge that takes what came last") {
  const int harm = harmful(
      1, 200, {.supersedes = [](const RecordHeader&, const RecordHeader&) { return true; }});
  std::printf("a merge that takes what came last: %d of 200 storms did harm\n", harm);
  CHECK(harm > 0);
}
