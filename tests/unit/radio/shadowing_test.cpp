#include "common/radio/shadowing.h"

#include <rapidcheck.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "common/core/random.h"

using namespace muster;
using namespace muster::radio;

namespace {

Vec3 place(Random& random, double size_m) {
  const double x = random.uniform(0, size_m), y = random.uniform(0, size_m);
  return {x, y, random.uniform(0, 0.2 * size_m)};
}

}  // namespace

TEST_CASE("shadowing is the same in both directions, to the last bit") {
  CHECK(rc::check([](std::uint64_t seed) {
    const Shadowing field(seed, 10);
    Random random(seed, kNoRobot, "places");
    for (int i = 0; i < 10; ++i) {
      const Vec3 a = place(random, 100), b = place(random, 100);
      RC_ASSERT(field.between(a, b) == field.between(b, a));
    }
  }));
}

TEST_CASE("shadowing has mean 0 and variance 1, near and far, over many sites") {
  for (const double apart_m : {1.0, 8.0, 60.0}) {
    double sum = 0, squares = 0;
    constexpr int kSites = 4000;
    for (std::uint64_t seed = 0; seed < kSites; ++seed) {
      Random random(seed, kNoRobot, "places");
      const Vec3 a = place(random, 100);
      const double s = Shadowing(seed, 10).between(a, a + Vec3(apart_m, 0, 0));
      sum += s;
      squares += s * s;
    }
    CHECK(sum / kSites == Approx(0).margin(0.06));
    CHECK(squares / kSites == Approx(1).margin(0.1));
  }
}

TEST_CASE("its correlation has fallen to 1/e after its distance and is gone after three") {
  constexpr int kSites = 4000;
  for (const auto& [moved_m, expected] :
       {std::pair{1.0, std::exp(-0.01)}, {10.0, std::exp(-1)}, {30.0, 0.0}}) {
    double products = 0;
    for (std::uint64_t seed = 0; seed < kSites; ++seed) {
      const Shadowing field(seed, 10);
      const Vec3 a(0, 0, 1), b(70, 20, 3);
      products += field.between(a, b) * field.between(a, b + Vec3(0, moved_m, 0));
    }
    CHECK(products / kSites == Approx(expected).margin(0.07));
  }
}

TEST_CASE("another seed is another site, and a field without extent is refused") {
  CHECK(Shadowing(1, 10).between({0, 0, 0}, {9, 0, 0}) !=
        Shadowing(2, 10).between({0, 0, 0}, {9, 0, 0}));
  CHECK_THROWS_AS(Shadowing(1, 0), std::invalid_argument);
}
