#include "common/route/predictor.h"

#include <catch2/catch.hpp>

using namespace muster::route;

TEST_CASE("the predictor is equation (9) less the time that has passed") {
  // A quarter explored in 60 s, 10 of 15 areas inspected: 4 · 1.5 · 60 = 360 s in all.
  CHECK(predict_remaining_s({1000, 250, 15, 10, 60}) == Approx(300));
}

TEST_CASE("without results the predictor extrapolates the explored volume") {
  CHECK(predict_remaining_s({1000, 250, 15, 0, 60}) == Approx(180));
  CHECK(predict_remaining_s({1000, 250, 0, 0, 60}) == Approx(180));
}

TEST_CASE("a single result of many areas does not blow the prediction up") {
  CHECK(predict_remaining_s({1000, 250, 30, 1, 60}) == Approx(180));
  CHECK(predict_remaining_s({1000, 250, 30, 2, 60}) == Approx(180));
}

TEST_CASE("the first prediction is the first slice, and every one is between 50 and 600 s") {
  CHECK(predict_remaining_s({1000, 0, 0, 0, 0}) == Approx(kFirstSlice_s));
  CHECK(predict_remaining_s({1000, 0, 0, 0, 60}) == Approx(600));
  CHECK(predict_remaining_s({1000, 1, 40, 4, 60}) == Approx(600));
  CHECK(predict_remaining_s({1000, 1000, 4, 4, 300}) == Approx(50));
  CHECK(predict_remaining_s({0, 0, 0, 0, 30}) == Approx(600));
}

TEST_CASE("more results than areas do not shorten the prediction") {
  CHECK(predict_remaining_s({1000, 500, 5, 9, 100}) == Approx(100));
}
