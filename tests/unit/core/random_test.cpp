#include "common/core/random.h"

#include <catch2/catch.hpp>

using namespace muster;

TEST_CASE("streams differ by seed, robot and purpose, and repeat") {
  Random a(1, RobotId{2}, "noise"), b(1, RobotId{2}, "noise");
  Random c(2, RobotId{2}, "noise"), d(1, RobotId{3}, "noise"), e(1, RobotId{2}, "loss");
  const auto first = a.next();
  CHECK(b.next() == first);
  CHECK(c.next() != first);
  CHECK(d.next() != first);
  CHECK(e.next() != first);
}

TEST_CASE("a normal draw has mean 0 and variance 1") {
  Random r(7, RobotId{0}, "test");
  double sum = 0, squares = 0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = r.normal();
    sum += x;
    squares += x * x;
  }
  CHECK(sum / kDraws == Approx(0).margin(0.03));
  CHECK(squares / kDraws == Approx(1).margin(0.05));
}
