#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/core/random.h"
#include "common/store/exchange.h"

namespace muster::store {

/// Robots that exchange records over a radio that loses, repeats, delays and cuts: a tick is 0.1 s,
/// what is sent in one is heard in the next. Knows everything that was ever written, so it can say
/// whether a digest lies.
class Air {
 public:
  struct Weather {
    double loss = 0, repeat = 0, delay = 0;
    std::size_t budget = 256 * 1024;
    bool single_number =
        false;  ///< digests of one number per stream: the scheme that loses records
  };

  Air(std::uint64_t seed, std::uint32_t robots) : random_(seed, kNoRobot, "air"), seed_(seed) {
    for (std::uint32_t i = 0; i < robots; ++i) start(RobotId{i}, 1);
  }

  Weather weather;

  void start(RobotId id, std::uint64_t epoch) {
    robots_[id] = std::make_unique<Robot>(id, epoch, seed_);
    used_epochs_[id].insert(epoch);
  }
  /// Started again with all it had.
  void restart_with_journal(RobotId id) {
    const RecordStore& old = store(id);
    auto fresh = std::make_unique<Robot>(id, next_epoch(id), seed_);
    for (std::uint32_t c = 1; c <= kRecordClasses; ++c) {
      for (const Record* record : old.all(RecordClass{c})) fresh->store.merge(*record);
    }
    for (const DigestEntry& e : old.digest()) fresh->store.raise(e.author, e.cls, e.complete);
    used_epochs_[id].insert(fresh->store.epoch());
    robots_[id] = std::move(fresh);
  }
  /// As after a crash without a journal.
  void restart_empty(RobotId id) { start(id, next_epoch(id)); }
  /// The same, with a clock that is behind: an epoch below the last one, but never used.
  void restart_behind(RobotId id) {
    const std::uint64_t epoch = next_epoch(id) - 15;
    if (!used_epochs_[id].contains(epoch)) start(id, epoch);
  }
  void kill(RobotId id) { robots_.erase(id); }
  bool alive(RobotId id) const { return robots_.contains(id); }
  std::vector<RobotId> living() const {
    std::vector<RobotId> out;
    for (const auto& [id, robot] : robots_) out.push_back(id);
    return out;
  }

  void link(RobotId a, RobotId b, bool up) {
    for (const auto& pair : {std::pair(a, b), std::pair(b, a)}) {
      if (up)
        links_.insert(pair);
      else
        links_.erase(pair);
    }
  }
  void link_all() {
    for (const auto& [a, robot_a] : robots_) {
      for (const auto& [b, robot_b] : robots_) {
        if (a < b) link(a, b, true);
      }
    }
  }

  void write(RobotId id, RecordClass cls, std::uint64_t key, std::size_t bytes = 40) {
    RecordStore& s = store(id);
    Record record{s.next_header(cls, key, now_), Bytes(bytes, static_cast<std::uint8_t>(key))};
    written_.push_back(record.header);
    s.insert_own(std::move(record));
  }

  RecordStore& store(RobotId id) { return robots_.at(id)->store; }
  Exchange& exchange(RobotId id) { return robots_.at(id)->exchange; }
  SimTime now() const { return now_; }

  void tick() {
    now_ = now_ + kTick;
    auto heard = std::move(in_flight_);
    in_flight_.clear();
    for (const Delivery& d : heard) {
      if (d.at > now_)
        in_flight_.push_back(d);
      else if (robots_.contains(d.to))
        hear(d);
    }
    for (auto& [id, robot] : robots_) speak(id, *robot);
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i) tick();
  }

  bool all_equal() {
    std::set<std::uint64_t> contents;
    for (const auto& [id, robot] : robots_) contents.insert(robot->store.content_hash());
    return contents.size() <= 1;
  }
  bool all_caught_up() {
    for (const auto& pair : links_) {
      if (!alive(pair.first) || !alive(pair.second)) continue;
      if (!exchange(pair.first).caught_up(pair.second, now_)) return false;
    }
    return true;
  }

  /// Does every store hold what its digest says it has seen, or newer?
  bool digests_are_true() {
    for (const auto& [id, robot] : robots_) {
      for (const DigestEntry& entry : robot->store.digest()) {
        const SeqSet beyond(entry.beyond);
        for (const RecordHeader& h : written_) {
          if (h.author != entry.author || h.cls != entry.cls) continue;
          if (h.seq > entry.complete && !beyond.contains(h.seq)) continue;
          const Record* held = robot->store.find(h.author.robot, h.cls, h.key);
          if (held == nullptr || held->header.version() < h.version()) return false;
        }
      }
    }
    return true;
  }

  std::uint64_t records_sent() {
    std::uint64_t n = 0;
    for (const auto& [id, robot] : robots_) n += robot->exchange.stats().records_sent;
    return n;
  }
  std::uint64_t ends_sent() {
    std::uint64_t n = 0;
    for (const auto& [id, robot] : robots_) n += robot->exchange.stats().ends_sent;
    return n;
  }
  std::uint64_t digests_sent() {
    std::uint64_t n = 0;
    for (const auto& [id, robot] : robots_) n += robot->exchange.stats().digests_sent;
    return n;
  }

 private:
  struct Robot {
    Robot(RobotId id, std::uint64_t epoch, std::uint64_t seed)
        : store(id, epoch), exchange(store, Random(seed, id, "exchange")) {}
    RecordStore store;
    Exchange exchange;
    std::uint64_t n = 0;
  };
  struct Beacon {
    std::uint64_t epoch = 0, digest_n = 0;
    std::vector<DigestEntry> digest;
  };
  struct Sent {
    RobotId from;
    std::uint64_t n = 0;
    std::optional<Beacon> beacon;
    std::optional<Record> record;
    std::optional<ExchangeEnd> end;
  };
  struct Delivery {
    SimTime at;
    RobotId to;
    std::shared_ptr<const Sent> what;
  };

  /// Well above the last, so that there is room for a clock that is behind.
  std::uint64_t next_epoch(RobotId id) {
    used_epochs_[id].insert(store(id).epoch());
    return (*used_epochs_[id].rbegin() / 10 + 2) * 10;
  }

  void hear(const Delivery& d) {
    Exchange& e = exchange(d.to);
    const Sent& m = *d.what;
    if (m.beacon) e.on_beacon(m.from, m.beacon->epoch, m.beacon->digest_n, m.beacon->digest, now_);
    if (m.record) e.on_record(m.from, m.n, *m.record, now_);
    if (m.end) e.on_end(m.from, m.n, *m.end);
  }

  void speak(RobotId id, Robot& robot) {
    for (auto& action : robot.exchange.step(now_, weather.budget, [&] { return ++robot.n; })) {
      Sent sent{id, action.n, std::nullopt, std::nullopt, std::move(action.end)};
      if (action.record != nullptr) sent.record = *action.record;
      broadcast(std::move(sent));
    }
    ++robot.n;  // something on board has a number too
    Beacon beacon{robot.store.epoch(), 0, {}};
    if (robot.exchange.digest_due(now_)) {
      beacon.digest_n = robot.exchange.digest_sent(now_);
      beacon.digest = robot.store.digest();
      if (weather.single_number) {
        for (DigestEntry& e : beacon.digest) {
          if (!e.beyond.empty()) e.complete = e.beyond.back().last;
          e.beyond.clear();
        }
      }
    }
    broadcast({id, ++robot.n, std::move(beacon), std::nullopt, std::nullopt});
  }

  void broadcast(Sent sent) {
    const auto what = std::make_shared<const Sent>(std::move(sent));
    for (const auto& [to, robot] : robots_) {
      if (!links_.contains({what->from, to})) continue;
      if (random_.chance(weather.loss)) continue;
      SimTime at = now_ + kTick;
      if (random_.chance(weather.delay))
        at = at + kTick * static_cast<std::int64_t>(1 + random_.below(3));
      in_flight_.push_back({at, to, what});
      if (random_.chance(weather.repeat)) in_flight_.push_back({at + kTick, to, what});
    }
  }

  Random random_;
  std::uint64_t seed_;
  SimTime now_;
  std::map<RobotId, std::unique_ptr<Robot>> robots_;
  std::map<RobotId, std::set<std::uint64_t>> used_epochs_;
  std::set<std::pair<RobotId, RobotId>> links_;
  std::vector<Delivery> in_flight_;
  std::vector<RecordHeader> written_;
};

}  // namespace muster::store
