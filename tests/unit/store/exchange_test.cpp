#include "common/store/exchange.h"

#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/unit/store/air.h"

using namespace muster;
using namespace muster::store;

namespace {

RobotId id(std::uint32_t i) { return RobotId{i}; }

/// Ticks until all stores are equal; -1 when not within `limit`.
int ticks_until_equal(Air& air, int limit) {
  for (int i = 0; i < limit; ++i) {
    if (air.all_equal() && air.all_caught_up()) return i;
    air.tick();
  }
  return -1;
}

}  // namespace

TEST_CASE("two robots that meet hold the same soon after") {
  Air air(1, 2);
  for (std::uint64_t k = 0; k < 20; ++k) air.write(id(0), RecordClass::kArea, k);
  for (std::uint64_t k = 0; k < 20; ++k) air.write(id(1), RecordClass::kMap, k % 5);
  air.ticks(20);
  CHECK_FALSE(air.all_equal());
  CHECK_FALSE(air.exchange(id(0)).caught_up(id(1), air.now()));
  CHECK(air.records_sent() == 0);
  CHECK(air.digests_sent() == 0);
  air.link_all();
  const int ticks = ticks_until_equal(air, 30);
  std::printf("two robots, 25 records: equal and aware of it after %d ticks, %lu sent, %lu ends\n",
              ticks, static_cast<unsigned long>(air.records_sent()),
              static_cast<unsigned long>(air.ends_sent()));
  REQUIRE(ticks >= 0);
  CHECK(ticks <= 10);
  CHECK(air.records_sent() == 25);
  CHECK(air.exchange(id(0)).caught_up(id(1), air.now()));
}

TEST_CASE("robots with nothing new only repeat their digests now and then") {
  Air air(2, 3);
  air.link_all();
  for (std::uint32_t i = 0; i < 3; ++i) air.write(id(i), RecordClass::kStatus, 1);
  air.ticks(60);
  const auto records = air.records_sent(), ends = air.ends_sent(), digests = air.digests_sent();
  air.ticks(300);
  CHECK(air.records_sent() == records);
  CHECK(air.ends_sent() == ends);
  CHECK(air.digests_sent() <= digests + 3 * 10);
}

TEST_CASE("robots in one place offer each record about once") {
  for (std::uint32_t robots : {2u, 5u, 13u, 49u}) {
    Air air(3, robots);
    air.link_all();
    for (std::uint32_t i = 0; i < robots; ++i) {
      for (std::uint64_t k = 0; k < 10; ++k) air.write(id(i), RecordClass::kArea, k);
    }
    const int ticks = ticks_until_equal(air, 100);
    REQUIRE(ticks >= 0);
    const double per_record = static_cast<double>(air.records_sent()) / (10.0 * robots);
    std::printf(
        "%u robots in one place: %.2f transmissions per record, %lu ends, %lu digests, %d ticks\n",
        robots, per_record, static_cast<unsigned long>(air.ends_sent()),
        static_cast<unsigned long>(air.digests_sent()), ticks);
    CHECK(per_record < 1.5);
  }
}

TEST_CASE("many who hold another's records do not all send them") {
  Air air(4, 13);
  for (std::uint64_t k = 0; k < 10; ++k) air.write(id(0), RecordClass::kInspection, k);
  for (std::uint32_t i = 0; i < 12; ++i) {
    for (std::uint32_t j = i + 1; j < 12; ++j) air.link(id(i), id(j), true);
  }
  REQUIRE(ticks_until_equal(air, 100) == -1);  // robot 12 is apart
  air.kill(id(0));
  const auto before = air.records_sent();
  air.link_all();
  const int ticks = ticks_until_equal(air, 100);
  REQUIRE(ticks >= 0);
  const auto sent = air.records_sent() - before;
  std::printf("11 forwarders, 10 records of a dead author: %lu sent, %d ticks\n",
              static_cast<unsigned long>(sent), ticks);
  CHECK(sent <= 40);
}

TEST_CASE("a broken exchange goes on where it ended, with anyone") {
  Air air(5, 3);
  air.weather.budget = 20'000;
  for (std::uint64_t k = 0; k < 50; ++k) air.write(id(0), RecordClass::kMap, k % 40, 4000);
  air.link(id(0), id(1), true);
  air.ticks(6);
  air.link(id(0), id(1), false);
  air.ticks(30);
  const auto first = air.store(id(1)).size();
  CHECK(first > 0);
  CHECK(first < 40);
  air.link(id(1), id(2), true);
  air.ticks(30);
  CHECK(air.store(id(2)).size() == first);
  air.link(id(0), id(2), true);
  const auto before = air.exchange(id(0)).stats().records_sent;
  REQUIRE(ticks_until_equal(air, 100) >= 0);
  CHECK(air.exchange(id(0)).stats().records_sent - before <= 40 - first);
  CHECK(air.digests_are_true());
}

TEST_CASE("what matters more is sent first, within the budget of a tick") {
  Air air(6, 2);
  air.write(id(0), RecordClass::kMap, 1, 1000);
  air.write(id(0), RecordClass::kInspection, 1, 1000);
  air.weather.budget = 1100;
  air.link_all();
  while (air.store(id(1)).size() == 0) air.tick();
  CHECK(air.store(id(1)).find(id(0), RecordClass::kInspection, 1) != nullptr);
  CHECK(air.store(id(1)).size() == 1);
  air.tick();
  CHECK(air.store(id(1)).size() == 2);
}

TEST_CASE("an end that was not heard whole, or is not for this start of us, raises nothing") {
  RecordStore store(id(1), 7);
  Exchange exchange(store, Random(1, id(1), "exchange"));
  const Author author{id(2), 1};
  exchange.on_beacon(id(2), 1, 0, {}, {});
  exchange.on_record(id(2), 5, {{author, RecordClass::kMap, 1, 4, {}, {}}, {}}, {});
  const auto complete = [&] {
    const auto it = store.streams().find({id(2), RecordClass::kMap, 1});
    return it == store.streams().end() ? 0 : it->second.complete;
  };
  const auto end = [&](std::uint64_t receiver_epoch, std::uint64_t first_n, std::uint64_t sent) {
    return ExchangeEnd{id(1), receiver_epoch, 1, first_n, {{author, RecordClass::kMap, 9, sent}}};
  };
  exchange.on_end(id(2), 8, end(7, 5, 2));  // one of two was lost
  exchange.on_end(id(2), 8, end(6, 5, 1));  // for an earlier start
  exchange.on_end(id(2), 8, end(7, 9, 0));  // a window that ends before it begins
  CHECK(complete() == 0);
  exchange.on_end(id(2), 8, end(7, 5, 1));
  CHECK(complete() == 9);
}

TEST_CASE("whatever a digest claims, it does no harm") {
  RecordStore store(id(1), 7);
  Exchange exchange(store, Random(1, id(1), "exchange"));
  store.insert_own({store.next_header(RecordClass::kArea, 1, {}), {}});
  constexpr std::uint64_t kMax = ~std::uint64_t{0};
  const std::vector<DigestEntry> nonsense{
      {{id(1), 7}, RecordClass::kArea, kMax, {{kMax, 1}, {0, kMax}, {5, kMax}}},
      {{id(1), kMax}, RecordClass{99}, 0, {{3, 4}, {1, 9}}},
      {{id(1), 7}, RecordClass::kArea, 0, {}}};
  exchange.on_beacon(id(2), kMax, kMax, nonsense, {});
  std::uint64_t n = 0;
  exchange.step({}, 1000, [&] { return ++n; });
  CHECK_FALSE(exchange.caught_up(id(2), {}));
  store.merge({{{id(1), kMax}, RecordClass::kArea, 1, kMax, {}, {}}, {}});
  store.raise({id(3), 1}, RecordClass::kMap, kMax);
  CHECK(store.digest().size() == 3);
}
