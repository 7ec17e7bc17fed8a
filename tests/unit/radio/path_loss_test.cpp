#include "common/radio/path_loss.h"

#include <rapidcheck.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "common/radio/presets.h"

using namespace muster;
using namespace muster::radio;

TEST_CASE("every preset exists, is in reason, and no other does") {
  for (const std::string& name : preset_names()) {
    const auto c = preset(name);
    REQUIRE(c);
    CHECK(c->range_m >= 5);
    CHECK(c->path_loss.has_value() == (name != "paper"));
    CHECK((c->bit_rate_mbps > 0) == (name != "paper"));
  }
  CHECK_FALSE(preset("wifi"));
  CHECK(preset("paper")->range_m == 5);
  CHECK(preset("paper")->line_of_sight);
}

TEST_CASE("radios reach as far as people find they do") {
  // Drones on 5 GHz: some hundred metres at the lowest rate; DW1000 at its fastest: some ten;
  // 900 MHz modules: kilometres.
  CHECK(preset("wifi-5ghz")->range_m > 60);
  CHECK(preset("wifi-5ghz")->range_m < 300);
  CHECK(preset("uwb")->range_m > 30);
  CHECK(preset("uwb")->range_m < 100);
  CHECK(preset("900mhz")->range_m > 1000);
  CHECK(preset("900mhz")->range_m < 10'000);
}

TEST_CASE("a tenth of the frames is lost at the sensitivity, all far below, none far above") {
  const PathLossConfig c;
  CHECK(frame_loss(c, c.sensitivity_dbm) == Approx(0.1));
  CHECK(frame_loss(c, c.sensitivity_dbm - 30) > 0.9999);
  CHECK(frame_loss(c, c.sensitivity_dbm + 30) < 1e-6);
}

TEST_CASE("a message of several frames needs them all") {
  const ChannelConfig c{.loss = 0.5, .frame_bytes = 1000};
  CHECK(message_loss(c, 0, 10) == Approx(0.5));
  CHECK(message_loss(c, 0.1, 0) == Approx(1 - 0.5 * 0.9));
  CHECK(message_loss(c, 0.1, 1000) == Approx(1 - 0.5 * 0.9));
  CHECK(message_loss(c, 0.1, 2001) == Approx(1 - 0.5 * std::pow(0.9, 3)));
  CHECK(message_loss(c, 1, 1) == 1);
}

TEST_CASE("what a planner expects never grows with distance, walls or the sender's weakness") {
  CHECK(rc::check([] {
    const auto name = *rc::gen::elementOf(preset_names());
    const ChannelConfig c = *preset(name);
    const double near_m = *rc::gen::inRange(1, 30'000) * 0.1;
    const double far_m = near_m + *rc::gen::inRange(0, 10'000) * 0.1;
    const int walls = *rc::gen::inRange(0, 4);
    RC_ASSERT(forecast(c, far_m, walls) <= forecast(c, near_m, walls));
    RC_ASSERT(forecast(c, near_m, walls + 1) <= forecast(c, near_m, walls));
    RC_ASSERT(forecast(c, near_m, walls) >= 0);
    RC_ASSERT(forecast(c, near_m, walls) <= 1);
    if (c.path_loss) {
      ChannelConfig weaker = c;
      weaker.path_loss->tx_power_dbm -= 3;
      RC_ASSERT(forecast(weaker, near_m, walls) <= forecast(c, near_m, walls));
    }
  }));
}

TEST_CASE("within the dependable range nine frames of ten are expected, beyond fewer") {
  for (const char* name : {"wifi-5ghz", "uwb", "900mhz"}) {
    const ChannelConfig c = *preset(name);
    CHECK(forecast(c, 0.99 * c.range_m, 0) >= 0.9);
    CHECK(forecast(c, 1.01 * c.range_m, 0) < 0.9);
  }
}

TEST_CASE("the papers' radio is a forecast of yes or no") {
  const ChannelConfig c;
  CHECK(forecast(c, 5, 0) == 1);
  CHECK(forecast(c, 5.01, 0) == 0);
  CHECK(forecast(c, 1, 1) == 0);
}
