#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/core/hash.h"
#include "common/core/random.h"
#include "common/store/exchange.h"
#include "tests/unit/store/disk.h"

namespace muster::store {

/// Robots that exchange records over a radio that loses, repeats, delays and cuts: a tick is 0.1 s,
/// what is sent in one is heard in the next. Each commits to its disk before what it says leaves
/// it, as robots do. Knows everything that was ever written and promised, so it can say who lied.
class Air {
 public:
  struct Weather {
    double loss = 0, repeat = 0, delay = 0;
    std::size_t budget = 256 * 1024;
  };
  /// What is different from the product.
  struct Setup {
    std::string files = "";  ///< a folder for real journals; empty: disks are played in memory
    RecordStore::Supersedes supersedes = RecordStore::is_newer;
    bool single_number = false;  ///< digests of one number per stream: a scheme that loses records
  };
  /// Where in its tick a process is killed.
  enum class Killed { kNot, kBeforeCommit, kAfterCommit, kWhileSending };

  Air(std::uint64_t seed, std::uint32_t robots) : Air(seed, robots, Setup{}) {}
  Air(std::uint64_t seed, std::uint32_t robots, Setup setup)
      : setup_(std::move(setup)), random_(seed, kNoRobot, "air"), seed_(seed) {
    for (std::uint32_t i = 0; i < robots; ++i) start(RobotId{i}, 1);
  }

  Weather weather;

  /// With all that it had committed. `later`: its clock says so; else it only knows that it is the
  /// next start.
  void start_with_disk(RobotId id, bool later) { start(id, later ? next_epoch(id) : 1); }
  /// As after a crash without a journal: what it promised went with its disk.
  void start_empty(RobotId id) {
    lose_disk(id);
    start(id, next_epoch(id));
  }
  /// The same, with a clock that is behind: an epoch below the last one, but never used.
  void start_behind(RobotId id) {
    const std::uint64_t epoch = next_epoch(id) - 15;
    if (used_epochs_[id].contains(epoch)) return;
    lose_disk(id);
    start(id, epoch);
  }
  /// Killed at that instant of its next tick.
  void kill_at(RobotId id, Killed when) { robots_.at(id)->killed = when; }
  void kill(RobotId id) {
    robots_.erase(id);
    disks_.at(id)->kill();
    unkept_.erase(id);
  }
  bool alive(RobotId id) const { return robots_.contains(id); }
  std::vector<RobotId> living() const {
    std::vector<RobotId> out;
    for (const auto& [id, robot] : robots_) out.push_back(id);
    return out;
  }

  void link(RobotId a, RobotId b, bool up) {
    link_one_way(a, b, up);
    link_one_way(b, a, up);
  }
  void link_one_way(RobotId from, RobotId to, bool up) {
    if (up)
      links_.insert({from, to});
    else
      links_.erase({from, to});
  }
  void cut_one_way_links() {
    std::erase_if(links_, [all = links_](const auto& link) {
      return !all.contains({link.second, link.first});
    });
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
    Record record{s.next_header(cls, key, now_),
                  Bytes(bytes, static_cast<std::uint8_t>(++writes_))};
    record.bytes[0] = static_cast<std::uint8_t>(writes_ >> 8);
    unkept_[id].push_back(record.header);
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
    for (const RobotId id : living()) speak(id);
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
    return std::ranges::all_of(robots_, [&](const auto& entry) {
      Promises now;
      for (const DigestEntry& e : entry.second->store.digest()) promise(now, e);
      return keeps(entry.second->store, now);
    });
  }
  /// Does every disk hold what its robot's digests ever said, or newer?
  bool promises_are_kept() {
    return std::ranges::all_of(disks_, [&](const auto& entry) {
      const auto& [id, disk] = entry;
      if (alive(id)) kill(id);
      RecordStore left(id, disk->open() + 1);
      disk->restore(left);
      return keeps(left, promised_[id]);
    });
  }
  /// Was no number ever on the air for two different records?
  bool numbers_are_unique() const { return numbers_are_unique_; }

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
    Robot(RobotId id, std::uint64_t epoch, std::uint64_t seed, RecordStore::Supersedes supersedes)
        : store(id, epoch, supersedes), exchange(store, Random(seed, id, "exchange")) {}
    RecordStore store;
    Exchange exchange;
    std::uint64_t n = 0;
    Killed killed = Killed::kNot;
  };
  struct Promise {
    std::uint64_t complete = 0;
    SeqSet beyond;
  };
  using Promises = std::map<StreamId, Promise>;
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

  void start(RobotId id, std::uint64_t epoch) {
    auto& disk = disks_[id];
    if (!disk && setup_.files.empty()) disk = std::make_unique<MemoryDisk>();
    if (!disk)
      disk = std::make_unique<FileDisk>(setup_.files + "/" + std::to_string(id.value) + ".db", id);
    epoch = std::max(epoch, disk->open() + 1);
    auto fresh = std::make_unique<Robot>(id, epoch, seed_, setup_.supersedes);
    disk->restore(fresh->store);
    robots_[id] = std::move(fresh);
    used_epochs_[id].insert(store(id).epoch());
  }
  void lose_disk(RobotId id) {
    if (alive(id)) kill(id);
    disks_.at(id)->wipe();
    promised_.erase(id);
  }
  /// Well above the last, so that there is room for a clock that is behind.
  std::uint64_t next_epoch(RobotId id) { return (*used_epochs_[id].rbegin() / 10 + 2) * 10; }

  static void promise(Promises& promises, const DigestEntry& e) {
    Promise& p = promises[{e.author.robot, e.cls, e.author.epoch}];
    p.complete = std::max(p.complete, e.complete);
    for (const SeqRange& range : e.beyond) p.beyond.insert(range);
  }
  bool keeps(const RecordStore& store, const Promises& promises) const {
    return std::ranges::all_of(written_, [&](const RecordHeader& h) {
      const auto p = promises.find({h.author.robot, h.cls, h.author.epoch});
      if (p == promises.end()) return true;
      if (h.seq > p->second.complete && !p->second.beyond.contains(h.seq)) return true;
      const Record* held = store.find(h.author.robot, h.cls, h.key);
      return (held != nullptr && held->header.version() >= h.version()) || is_void(store, h);
    });
  }
  /// A newer start of its author is known, and has voided it.
  static bool is_void(const RecordStore& store, const RecordHeader& h) {
    return voided_by_restart(h.cls) && std::ranges::any_of(store.streams(), [&](const auto& s) {
             return s.first.robot == h.author.robot && s.first.epoch > h.author.epoch;
           });
  }

  void hear(const Delivery& d) {
    Exchange& e = exchange(d.to);
    const Sent& m = *d.what;
    if (m.beacon) e.on_beacon(m.from, m.beacon->epoch, m.beacon->digest_n, m.beacon->digest, now_);
    if (m.record) e.on_record(m.from, m.n, *m.record, now_);
    if (m.end) e.on_end(m.from, m.n, *m.end);
  }

  void speak(RobotId id) {
    Robot& robot = *robots_.at(id);
    std::vector<Sent> said = words_of(id, robot);
    if (robot.killed == Killed::kBeforeCommit) return kill(id);
    disks_.at(id)->commit(robot.store);
    used_epochs_[id].insert(robot.store.epoch());
    auto kept = std::move(unkept_[id]);
    unkept_.erase(id);
    written_.insert(written_.end(), kept.begin(), kept.end());
    if (robot.killed == Killed::kAfterCommit) return kill(id);
    if (robot.killed == Killed::kWhileSending) said.resize(random_.below(said.size()));
    for (Sent& sent : said) broadcast(std::move(sent));
    if (robot.killed == Killed::kWhileSending) kill(id);
  }

  std::vector<Sent> words_of(RobotId id, Robot& robot) {
    std::vector<Sent> said;
    for (auto& action : robot.exchange.step(now_, weather.budget, [&] { return ++robot.n; })) {
      Sent sent{id, action.n, std::nullopt, std::nullopt, std::move(action.end)};
      if (action.record != nullptr) {
        Bytes buffer;
        const RecordView view = robot.store.read(*action.record, buffer);
        sent.record = Record{view.header, Bytes(view.bytes.begin(), view.bytes.end())};
      }
      said.push_back(std::move(sent));
    }
    ++robot.n;  // something on board has a number too
    Beacon beacon{robot.store.epoch(), 0, {}};
    if (robot.exchange.digest_due(now_)) {
      beacon.digest_n = robot.exchange.digest_sent(now_);
      beacon.digest = robot.store.digest();
      if (setup_.single_number) to_single_numbers(beacon.digest);
    }
    said.push_back({id, ++robot.n, std::move(beacon), std::nullopt, std::nullopt});
    return said;
  }
  static void to_single_numbers(std::vector<DigestEntry>& digest) {
    for (DigestEntry& e : digest) {
      if (!e.beyond.empty()) e.complete = e.beyond.back().last;
      e.beyond.clear();
    }
  }

  /// What is said is said, heard or not.
  void remember(const Sent& sent) {
    if (sent.beacon) {
      for (const DigestEntry& e : sent.beacon->digest) promise(promised_[sent.from], e);
    }
    if (!sent.record) return;
    const RecordHeader& h = sent.record->header;
    const std::uint64_t hash = Hasher().add(h.key).add_bytes(sent.record->bytes).value();
    const auto [it, first] = aired_.try_emplace({h.author, h.cls, h.seq}, hash);
    numbers_are_unique_ &= first || it->second == hash;
  }

  void broadcast(Sent sent) {
    remember(sent);
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

  const Setup setup_;
  Random random_;
  std::uint64_t seed_;
  SimTime now_;
  std::map<RobotId, std::unique_ptr<Robot>> robots_;
  std::map<RobotId, std::set<std::uint64_t>> used_epochs_;
  std::set<std::pair<RobotId, RobotId>> links_;
  std::vector<Delivery> in_flight_;
  std::map<RobotId, std::unique_ptr<Disk>> disks_;
  std::vector<RecordHeader> written_;  // and committed
  std::map<RobotId, std::vector<RecordHeader>> unkept_;
  std::map<RobotId, Promises> promised_;
  std::map<std::tuple<Author, RecordClass, std::uint64_t>, std::uint64_t>
      aired_;  // by number: hash
  bool numbers_are_unique_ = true;
  std::uint64_t writes_ = 0;
};

}  // namespace muster::store
