#include "common/dds/lockstep.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <future>
#include <optional>
#include <vector>

#include "common/dds/convert.h"
#include "common/dds/lockstep_world.h"
#include "tests/free_domain.h"

namespace muster::dds {
namespace {

using namespace std::chrono_literals;
using mission::Message;
using mission::MessageClass;

constexpr RobotId kRobot{7};

/// World and radio played by hand: what they would hear of one robot, in one place.
class Barrier {
 public:
  explicit Barrier(const BarrierConfig& config)
      : bus_(make_participant(participant_config(config, config.domain, kHub))),
        air_(make_participant(participant_config(config, config.domain + 1, kHub))) {
    tick_.add(*bus_, MessageClass::kTick, kSimPartition, {}, Delivery::kLatest);
    ways_ = WriterSet(*bus_, kSampleClasses, bus_partition(kRobot), {});
    down_ = WriterSet(*air_, mission::kAirClasses, down_partition(kRobot), {});
    commands_ = ReaderSet(*bus_, kCommandClasses, "bus.*", bus_in_.on_message(), {});
    done_.add(*bus_, MessageClass::kDone, kSimPartition, bus_in_.on_message(), {});
    up_ = ReaderSet(*air_, mission::kAirClasses, "up.*", air_in_.on_message(), {});
    done_.add(*air_, MessageClass::kDone, kSimPartition, air_in_.on_message(), {});
  }

  bool matched() const {
    return tick_.matched(1) && ways_.matched(1) && down_.matched(1) && commands_.matched(1) &&
           done_.matched(1) && up_.matched(1);
  }
  void say(std::uint64_t k, mission::TickPhase phase = mission::TickPhase::kRun) {
    mission::Tick tick;
    tick.envelope = {.n = k, .src = RobotId{}, .cls = MessageClass::kTick, .sent = {}};
    tick.k = k;
    tick.phase = phase;
    tick.alive = {kRobot};
    tick_.write(encode(tick));
  }
  /// The next answers to a tick on the bus and on air; nullopt when either does not come.
  struct Answers {
    std::optional<mission::Done> bus, air;
  };
  Answers answers() {
    const auto to_tick = [](const mission::Done& d) { return d.k != kReady && d.k != kBusy; };
    return {next(bus_in_, bus_heard_, to_tick), next(air_in_, air_heard_, to_tick)};
  }
  /// The robot has said on both domains that it is matched.
  bool ready() {
    const auto says = [](const mission::Done& d) { return d.k == kReady; };
    return next(bus_in_, bus_heard_, says) && next(air_in_, air_heard_, says);
  }

 private:
  template <class Condition>
  static std::optional<mission::Done> next(Inbox& inbox, std::vector<Message>& heard,
                                           const Condition& wanted) {
    const auto deadline = in(20s);
    while (Inbox::Clock::now() < deadline) {
      for (Message& m : inbox.take(Inbox::Clock::now() + 50ms)) heard.push_back(std::move(m));
      while (!heard.empty()) {
        auto done = decode<mission::Done>(heard.front());
        heard.erase(heard.begin());
        if (wanted(done)) return done;
      }
    }
    return std::nullopt;
  }

  Inbox bus_in_, air_in_;
  std::vector<Message> bus_heard_, air_heard_;
  std::unique_ptr<Participant> bus_, air_;
  WriterSet tick_, ways_, down_;
  ReaderSet commands_, done_, up_;
};

TEST_CASE("a robot answers a tick that is said again, and does not step again") {
  const Vendor vendor = GENERATE(Vendor::kCyclone, Vendor::kFast);
  const std::uint32_t domain = test::free_domain();
  // Cyclone: a process cannot be the hub of two domains with Fast DDS.
  Barrier barrier(BarrierConfig::from(Vendor::kCyclone, domain));
  const BarrierConfig config = BarrierConfig::from(vendor, domain);
  std::vector<std::uint64_t> steps;
  const volatile std::sig_atomic_t stop = 0;
  auto robot = std::async(std::launch::async, [&] {
    RobotLockstep lockstep(config, kRobot, false);
    return lockstep.run(
        [&](const mission::StepInput& input) {
          steps.push_back(input.tick);
          mission::StepOutput output;
          output.trace = 100 + input.tick;
          return output;
        },
        stop);
  });
  for (int i = 0; i < 400 && !barrier.matched(); ++i) std::this_thread::sleep_for(50ms);
  REQUIRE(barrier.matched());
  REQUIRE(barrier.ready());
  for (const std::uint64_t k : {1u, 1u, 1u, 2u, 2u}) {
    barrier.say(k);
    const Barrier::Answers answers = barrier.answers();
    REQUIRE(answers.bus);
    REQUIRE(answers.air);
    for (const auto& answer : {*answers.bus, *answers.air}) {
      CHECK(answer.k == k);
      CHECK(answer.trace == 100 + k);
      CHECK(answer.process == kRobot);
    }
  }
  barrier.say(3, mission::TickPhase::kEnd);
  robot.get();
  CHECK(steps == std::vector<std::uint64_t>{1, 2});
}

std::uint64_t trace_of(RobotId who, std::uint64_t k) { return std::uint64_t{100} * who.value + k; }

/// One robot, the station, and the radio played by hand: all that the world needs to start.
class Others {
 public:
  explicit Others(const BarrierConfig& config)
      : air_(make_participant(participant_config(config, config.domain + 1, kHub))) {
    ear_ = WriterSet(*air_, mission::kAirClasses, down_partition(kRobot), {});
  }
  /// After the world, which is the hub of the bus.
  void join(const BarrierConfig& config) {
    bus_ = make_participant(participant_config(config, config.domain, kRadioOnBus));
    for (int i = 0; i < 2; ++i) ticks_.add(*bus_, MessageClass::kTick, kSimPartition, nothing, {});
    ticks_.add(*bus_, MessageClass::kTruth, kSimPartition, nothing, {});
    samples_ = ReaderSet(*bus_, kSampleClasses, bus_partition(kRobot), nothing, {});
    samples_.add(*bus_, MessageClass::kOperatorRequest, bus_partition(kRobot), nothing, {});
    commands_ = WriterSet(*bus_, kCommandClasses, bus_partition(kRobot), {});
    for (WriterSet* done : {&robot_, &radio_})
      done->add(*bus_, MessageClass::kDone, kSimPartition, {});
  }
  void answer(std::uint64_t k, Life life = kFirstLife) {
    say(robot_, kRobot, k, life);
    say(radio_, kRadioId, k, life);
  }
  /// Nobody tells the middleware of a death: what listened before goes on being matched.
  void listen_again(Life life) {
    again_ = ReaderSet(*bus_, kSampleClasses, bus_partition(kRobot, life), nothing, {});
    again_.add(*bus_, MessageClass::kOperatorRequest, bus_partition(kRobot, life), nothing, {});
  }
  /// What the radio does when it expects the station.
  void open_way_again(Life life) {
    ear_ = WriterSet(*air_, mission::kAirClasses, down_partition(kRobot, life), {});
  }

 private:
  static void nothing(Message&&) {}
  static void say(const WriterSet& writer, RobotId who, std::uint64_t k, Life life) {
    mission::Done done;
    if (k == kReady) done = ready({{kRobot, life}});
    done.k = k;
    done.process = who;
    done.trace = trace_of(who, k);
    done.envelope = {.n = k, .src = who, .cls = MessageClass::kDone, .sent = {}};
    writer.write(encode(done));
  }

  std::unique_ptr<Participant> air_, bus_;
  WriterSet ear_, commands_, robot_, radio_;
  ReaderSet ticks_, samples_, again_;
};

/// A world whose clock may start.
struct Started {
  const BarrierConfig config = BarrierConfig::from(Vendor::kCyclone, test::free_domain());
  Others others{config};
  WorldLockstep world{config, {kRobot}, kRobot};

  Started() {
    others.join(config);
    auto started = std::async(std::launch::async, [&] { world.await_everyone(); });
    while (started.wait_for(50ms) == std::future_status::timeout) others.answer(kReady);
    started.get();
  }
  /// Between two ticks.
  void kill() {
    world.notify_lost(kRobot);
    world.await_lost(kRobot);
  }
};

TEST_CASE("an answer said again does not count for the next tick") {
  Started started;
  auto& [config, others, world] = started;
  for (std::uint64_t k = 1; k <= 5; ++k) {
    world.announce(k);
    if (k > 1) others.answer(k - 1);
    others.answer(k);
    CHECK(world.await_robots().robots.at(kRobot).trace == trace_of(kRobot, k));
    others.answer(k);  // and once more, between the two waits
    CHECK(world.await_radio().k == k);
    others.answer(k);
  }
  world.end("enough");
}

TEST_CASE("regress: who comes back is matched when its own readers are, not those of its dead") {
  Started started;
  auto& [config, others, world] = started;
  std::future<bool> back;
  const auto is_back_while_saying = [&](Life life, std::chrono::milliseconds longest) {
    const auto deadline = in(longest);
    while (Inbox::Clock::now() < deadline && back.wait_for(50ms) == std::future_status::timeout)
      others.answer(kReady, life);
    return back.wait_for(0ms) == std::future_status::ready;
  };
  const auto start_again = [&] {
    const Life life = world.expect(kRobot);
    others.open_way_again(life);
    back = std::async(std::launch::async, [&] { return world.await_back(kRobot); });
    return life;
  };
  started.kill();
  const Life deaf = start_again();
  CHECK_FALSE(is_back_while_saying(deaf, 500ms));
  world.notify_lost(kRobot);
  CHECK_FALSE(back.get());
  const Life hearing = start_again();
  others.listen_again(hearing);
  CHECK_FALSE(is_back_while_saying(deaf, 500ms));
  CHECK(is_back_while_saying(hearing, 20s));
  CHECK(back.get());
  world.end("enough");
}

TEST_CASE("regress: who dies on its way back is not waited for, and may come back later") {
  Started started;
  auto& [config, others, world] = started;
  started.kill();
  world.expect(kRobot);
  auto back = std::async(std::launch::async, [&] { return world.await_back(kRobot); });
  CHECK(back.wait_for(200ms) == std::future_status::timeout);
  world.notify_lost(kRobot);
  CHECK_FALSE(back.get());
  CHECK(world.alive().empty());
  const Life third = world.expect(kRobot);
  CHECK(third == kFirstLife + 2);
  others.open_way_again(third);
  others.listen_again(third);
  back = std::async(std::launch::async, [&] { return world.await_back(kRobot); });
  while (back.wait_for(50ms) == std::future_status::timeout) others.answer(kReady, third);
  CHECK(back.get());
  world.end("enough");
}

}  // namespace
}  // namespace muster::dds
