// Robots on a slow radio: what they have to tell each other goes at the pace of the air.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "common/dds/convert.h"
#include "common/radio/airtime.h"
#include "common/radio/presets.h"
#include "common/robot/robot.h"
#include "commsim/relay.h"
#include "tests/unit/robot/fixtures.h"

using namespace muster;

namespace {

constexpr RobotId kGone{99};  // whose records they hold

mission::Mission fleet_of(std::uint32_t robots, const char* preset) {
  mission::Mission m;
  m.hull = Box::from_corners({-15, -15, 0}, {15, 15, 8});
  m.boxes = {Box::from_corners({2, -4, 0.3}, {10, 4, 6})};
  m.standing.t0 = Duration::from_s(3000);
  m.standing.period = m.standing.window = Duration::from_s(30);
  static_cast<radio::ChannelConfig&>(m.radio) = *radio::preset(preset);
  m.radio.path_loss->shadowing_db = m.radio.path_loss->asymmetry_db = 0;
  for (std::uint32_t i = 0; i < robots; ++i) {
    mission::RobotConfig r;
    r.id = RobotId{i};
    r.role = i == 0 ? mission::Role::kStation : mission::Role::kInspector;
    r.start.p = {1.5 * i, 0, 1};
    m.fleet.push_back(r);
  }
  return m;
}

class Fleet {
 public:
  Fleet(std::uint32_t robots, const char* preset)
      : mission_(fleet_of(robots, preset)),
        air_(mission_.radio),
        relay_(mission_, radio::Obstacles{.line_of_sight = [](auto&, auto&) { return true; },
                                          .walls = [](auto&, auto&) { return 0; }}) {
    for (const mission::RobotConfig& r : mission_.fleet) {
      robots_.push_back(
          std::make_unique<robot::Robot>(mission_, r.id, std::make_unique<robot::Idle>(), 1));
      truth_.robots.push_back({r.id, mission::VehicleState::kMoving, r.start, Vec3::Zero()});
    }
  }

  /// Comes to one of them from nowhere.
  template <typename Body>
  void give(std::uint32_t to, store::RecordClass cls, std::uint64_t key, const Body& body) {
    const store::RecordHeader header{{kGone, 1}, cls, key, ++seq_[cls], {}, {}};
    arriving_[RobotId{to}].push_back(dds::wrap({++n_, kGone, mission::message_class(cls), {}},
                                               dds::encode_record(header, body)));
  }
  void give_images(std::uint32_t to, std::uint32_t parts) {
    mission::Inspection image;
    image.area = {kGone, to};
    image.parts = parts + 1;
    image.payload.assign(290, 7);
    for (image.part = 1; image.part <= parts; ++image.part) {
      give(to, store::RecordClass::kImage, robot::image_key(image.area, image.part), image);
    }
  }

  void tick() {
    truth_.k = ++k_;
    truth_.time = time_of_tick(k_);
    std::map<RobotId, std::vector<mission::Message>> sent;
    for (auto& robot : robots_) {
      mission::StepInput input{.tick = k_, .now = time_of_tick(k_), .bus = {}, .air = {}};
      input.air = std::exchange(arriving_[robot->id()], {});
      sent[robot->id()] = robot->step(input).air;
      for (const mission::Message& m : sent[robot->id()]) on_air_s_ += air_.of(m.cdr.size()).s();
    }
    arriving_ = relay_.step(truth_, sent).deliveries;
  }

  bool all_have(std::size_t records) const {
    return std::ranges::all_of(
        robots_, [&](const auto& r) { return r->knowledge().store().size() >= records; });
  }
  const robot::Robot& robot(std::size_t i) const { return *robots_.at(i); }
  std::uint64_t dropped(const char* why) const { return relay_.summary()["air"]["dropped"][why]; }
  double used() const { return on_air_s_ / time_of_tick(k_).s(); }
  double seconds() const { return time_of_tick(k_).s(); }

 private:
  mission::Mission mission_;
  radio::Airtime air_;
  commsim::Relay relay_;
  std::vector<std::unique_ptr<robot::Robot>> robots_;
  mission::Truth truth_;
  std::map<RobotId, std::vector<mission::Message>> arriving_;
  std::map<store::RecordClass, std::uint64_t> seq_;
  std::uint64_t n_ = 0, k_ = 0;
  double on_air_s_ = 0;
};

void exchange(std::uint32_t robots) {
  constexpr std::uint32_t kParts = 1000;
  Fleet fleet(robots, "900mhz");
  for (std::uint32_t i = 0; i < robots; ++i) fleet.give_images(i, kParts / robots);
  const std::size_t all = kParts / robots * robots;
  int ticks = 0;
  while (!fleet.all_have(all) && ++ticks < 6000) fleet.tick();
  CHECK(fleet.all_have(all));
  UNSCOPED_INFO(fmt::format("{} robots: {:.0f} s, air used {:.2f}, dropped for airtime {}", robots,
                            fleet.seconds(), fleet.used(), fleet.dropped("airtime")));
  CHECK(fleet.dropped("airtime") == 0);
  CHECK(fleet.used() > 0.7);
  CHECK(fleet.used() <= 1);
}

}  // namespace

TEST_CASE("two robots fill a slow radio and lose nothing to it") { exchange(2); }

TEST_CASE("four robots share a slow radio and lose nothing to it") { exchange(4); }

TEST_CASE("on a slow radio plans arrive before images") {
  Fleet fleet(2, "900mhz");
  fleet.give_images(0, 300);
  fleet.give(0, store::RecordClass::kPlan, 0, mission::Plan{});
  const auto heard = [&] {
    return fleet.robot(1).knowledge().store().all(store::RecordClass::kPlan).size();
  };
  while (heard() == 0 && fleet.seconds() < 60) fleet.tick();
  CHECK(fleet.robot(1).knowledge().store().all(store::RecordClass::kImage).size() < 30);
  CHECK(fleet.seconds() < 5);
}
