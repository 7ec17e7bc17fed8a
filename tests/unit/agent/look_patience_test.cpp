#include "agent/strategy/look_patience.h"

#include <catch2/catch.hpp>

using namespace muster;
using agent::LookPatience;

namespace {

void look(LookPatience& patience, int times, const std::vector<Vec3>& sighted = {}) {
  for (int i = 0; i < times; ++i) patience.look(sighted);
}

}  // namespace

TEST_CASE("looking goes on for half as many looks as it took to find the last place") {
  LookPatience patience;
  for (int place = 1; place <= 10; ++place) {
    look(patience, 39);
    look(patience, 1, {{2.0 * place, 0, 2}});
  }
  look(patience, 200);
  CHECK_FALSE(patience.exhausted());
  look(patience, 1);
  CHECK(patience.exhausted());
  look(patience, 1, {{2.1, 0.2, 2}});  // noise
  CHECK(patience.exhausted());
  look(patience, 1, {{30, 0, 2}});
  CHECK_FALSE(patience.exhausted());
}

TEST_CASE("a box without anything to find is looked at for a while all the same") {
  LookPatience patience;
  look(patience, 60);
  CHECK_FALSE(patience.exhausted());
  look(patience, 1);
  CHECK(patience.exhausted());
}
