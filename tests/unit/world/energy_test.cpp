#include "commsim/world/energy.h"

#include <catch2/catch.hpp>

#include "tests/unit/world/fixtures.h"

using namespace muster;
using namespace muster::world;
using namespace muster::world::testing;

namespace {

mission::Mission thirsty(std::size_t robots) {
  std::vector<mission::RobotConfig> fleet;
  for (std::uint32_t i = 0; i < robots; ++i) {
    fleet.push_back(robot(i + 1, mission::Role::kInspector, {0, 0, 2}));
    fleet.back().vehicle.capacity_mah = 100;
    fleet.back().vehicle.discharge_mah_per_s = 1;
  }
  mission::Mission m = mission_of(fleet);
  m.charging.push_back({{{0, 0, 2}, 0}, 1, 0.1, 1});
  return m;
}

void run_for(Energy& energy, const std::vector<Energy::Use>& uses, double s) {
  for (int i = 0; i < static_cast<int>(std::lround(s * 50)); ++i) energy.step(uses, {20'000});
}

}  // namespace

TEST_CASE("a battery is used up in the air and not on the ground") {
  Energy energy(thirsty(2));
  run_for(energy, {{{5, 0, 2}, false}, {{5, 0, 0}, true}}, 40);
  CHECK(energy.battery(0).charge == Approx(0.6).margin(1e-9));
  CHECK(energy.battery(1).charge == 1);
  run_for(energy, {{{5, 0, 2}, false}, {{5, 0, 0}, true}}, 100);
  CHECK(energy.battery(0).charge == 0);
}

TEST_CASE("no discharge rate, no discharge") {
  mission::Mission m = thirsty(1);
  m.fleet[0].vehicle.discharge_mah_per_s = 0;
  Energy energy(m);
  run_for(energy, {{{5, 0, 2}, false}}, 100);
  CHECK(energy.battery(0).charge == 1);
}

TEST_CASE("charging slots queue in the order of asking") {
  Energy energy(thirsty(3));
  const std::vector<Energy::Use> here(3, {{0, 0, 2}, true});
  const std::vector<Energy::Use> away(3, {{9, 0, 2}, false});
  run_for(energy, away, 50);
  energy.ask(2, 0);
  energy.ask(0, 0);
  run_for(energy, here, 1);
  CHECK(energy.battery(2).charging);
  CHECK_FALSE(energy.battery(0).charging);
  CHECK(energy.battery(0).station == 0);
  CHECK(energy.battery(1).station == -1);
  run_for(energy, here, 4.5);  // full: its slot goes to the next
  CHECK(energy.battery(2).charge == 1);
  CHECK(energy.battery(2).station == -1);
  CHECK(energy.battery(0).charging);
}

TEST_CASE("who waits too far away lets the next one in, and who leaves frees the slot") {
  Energy energy(thirsty(2));
  run_for(energy, std::vector<Energy::Use>(2, {{9, 0, 2}, false}), 50);
  energy.ask(0, 0);
  energy.ask(1, 0);
  run_for(energy, {{{9, 0, 2}, true}, {{0, 0, 2}, true}}, 1);
  CHECK_FALSE(energy.battery(0).charging);
  CHECK(energy.battery(1).charging);
  run_for(energy, {{{0, 0, 2}, true}, {{9, 0, 2}, true}}, 1);
  CHECK(energy.battery(0).charging);
  CHECK(energy.battery(1).station == -1);
  energy.ask(0, 7);  // there is no such station
  CHECK(energy.battery(0).station == -1);
}
