#include "agent/strategy/look_patience.h"

#include <catch2/catch.hpp>

using muster::agent::LookPatience;

TEST_CASE("looking goes on for half as many looks as it took to find the last place") {
  LookPatience patience;
  std::uint64_t looks = 0;
  for (std::size_t places = 1; places <= 10; ++places) patience.weigh(looks += 40, places);
  patience.weigh(looks + 200, 10);
  CHECK_FALSE(patience.exhausted());
  patience.weigh(looks + 201, 10);
  CHECK(patience.exhausted());
  patience.weigh(looks + 202, 11);  // somebody else found it
  CHECK_FALSE(patience.exhausted());
}

TEST_CASE("a box without anything to find is looked at for a while all the same") {
  LookPatience patience;
  patience.weigh(60, 0);
  CHECK_FALSE(patience.exhausted());
  patience.weigh(61, 0);
  CHECK(patience.exhausted());
}
