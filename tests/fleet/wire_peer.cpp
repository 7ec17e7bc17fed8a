// One process of the wire test: speaks every topic to the hub (or, as the hub, to every agent),
// large and small, and checks all that it hears. Says what it has done on stdout and leaves when
// stdin ends.
//   wire_peer VENDOR DOMAIN hub AGENT[,AGENT…]
//   wire_peer VENDOR DOMAIN agent NUMBER
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <future>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/dds/convert.h"
#include "common/dds/participant.h"

namespace {

using namespace muster;
using mission::MessageClass;

constexpr MessageClass kTopics[] = {MessageClass::kBeacon,     MessageClass::kMapBlock,
                                    MessageClass::kArea,       MessageClass::kInspection,
                                    MessageClass::kPlan,       MessageClass::kMeeting,
                                    MessageClass::kStatus,     MessageClass::kExchangeEnd,
                                    MessageClass::kOdometry,   MessageClass::kScan,
                                    MessageClass::kSightings,  MessageClass::kBattery,
                                    MessageClass::kInspected,  MessageClass::kOperatorRequest,
                                    MessageClass::kTrajectory, MessageClass::kInspect,
                                    MessageClass::kCharge,     MessageClass::kTick,
                                    MessageClass::kDone,       MessageClass::kTruth};
constexpr int kTopicCount = static_cast<int>(std::size(kTopics));
constexpr std::size_t kSizes[] = {100, 1396, 5000, 64000, 70000, 1'000'000};
constexpr std::uint64_t kBurst = 200;  // further small ones, as fast as they go
constexpr std::uint64_t kPerTopic = std::size(kSizes) + kBurst;
constexpr std::uint32_t kIntruder = 999;

/// The n-th message of `src` on this topic; nothing but its envelope has a meaning.
Bytes content(MessageClass cls, std::uint32_t src, std::uint64_t n) {
  mission::ExchangeEnd start;  // only its envelope matters
  start.envelope = {n, RobotId{src}, cls, SimTime{}};
  Bytes cdr = dds::encode(start).cdr;
  std::size_t i = cdr.size();
  cdr.resize(n <= std::size(kSizes) ? kSizes[n - 1] : 100 + 4 * (n % 50));
  Random random(n, RobotId{src}, mission::topic_name(cls));
  for (std::uint64_t word = 0; i < cdr.size(); ++i, word >>= 8) {
    if (word == 0) word = random.next();
    cdr[i] = static_cast<std::uint8_t>(word);
  }
  return cdr;
}

/// Everything heard, checked: from whom, in whose partition, what, in order.
class Ear {
 public:
  explicit Ear(std::set<std::uint32_t> expected) : expected_(std::move(expected)) {}

  dds::OnMessage on_message() {
    return [this](mission::Message&& m) {
      const std::lock_guard lock(mutex_);
      hear(m);
      changed_.notify_all();
    };
  }
  dds::OnMatch on_match() {
    return [this] {
      const std::lock_guard lock(mutex_);
      changed_.notify_all();
    };
  }
  /// Throws Failure when it takes too long or something wrong was heard.
  template <class Condition>
  void wait(const std::string& what, Condition condition) {
    std::unique_lock lock(mutex_);
    const bool done = changed_.wait_for(lock, std::chrono::seconds(60),
                                        [&] { return closed_ || !wrong_.empty() || condition(); });
    if (!wrong_.empty()) throw Failure(wrong_);
    if (!done) throw Failure("waited in vain for " + what + "; " + heard());
  }
  /// Calls `again` every 50 ms until `condition` holds.
  template <class Again, class Condition>
  void repeat(const std::string& what, Again again, Condition condition) {
    for (int i = 0; i < 400; ++i) {
      again();
      std::unique_lock lock(mutex_);
      if (changed_.wait_for(lock, std::chrono::milliseconds(50), condition)) return;
    }
    const std::lock_guard lock(mutex_);
    throw Failure("waited in vain for " + what + "; " + heard());
  }

  /// Until `close`, however long that takes. Throws Failure when something wrong is heard.
  void wait_for_close() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || !wrong_.empty(); });
    if (!wrong_.empty()) throw Failure(wrong_);
  }
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

  // For conditions: the lock is held.
  bool begun(std::uint32_t src) const {
    const auto found = last_.lower_bound({src, MessageClass{}});
    return found != last_.end() && found->first.first == src && found->second > 0;
  }
  bool ready(std::uint32_t src) const { return all_topics(src, 0); }
  bool complete(std::uint32_t src) const { return all_topics(src, kPerTopic); }

 private:
  void hear(const mission::Message& m) {
    const mission::Envelope e = dds::peek_envelope(m.cdr);
    const std::uint32_t src = e.src.value;
    const std::string who = "message " + std::to_string(e.n) + " of " + std::to_string(src) +
                            " on " + mission::topic_name(m.cls);
    if (!expected_.contains(src)) return complain(who + " is not for us");
    std::uint64_t& last = last_[{src, m.cls}];
    if (e.n == 0) return;  // says that it is ready
    if (e.n != last + 1) return complain(who + " comes after " + std::to_string(last));
    if (m.cdr != content(m.cls, src, e.n)) return complain(who + " has other bytes");
    last = e.n;
  }
  bool all_topics(std::uint32_t src, std::uint64_t at_least) const {
    return std::all_of(std::begin(kTopics), std::end(kTopics), [&](MessageClass cls) {
      const auto found = last_.find({src, cls});
      return found != last_.end() && found->second >= at_least;
    });
  }
  /// How far each topic came that is not at its end.
  std::string heard() const {
    std::ostringstream all;
    all << "heard:";
    for (const std::uint32_t src : expected_) {
      for (const MessageClass cls : kTopics) {
        const auto found = last_.find({src, cls});
        if (found != last_.end() && found->second == kPerTopic) continue;
        all << ' ' << src << '/' << mission::topic_name(cls) << '=';
        found == last_.end() ? all << "nothing" : all << found->second;
      }
    }
    return all.str();
  }
  void complain(const std::string& what) {
    if (wrong_.empty()) wrong_ = what;
  }

  std::set<std::uint32_t> expected_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::pair<std::uint32_t, MessageClass>, std::uint64_t> last_;
  std::string wrong_;
  bool closed_ = false;
};

struct Link {
  std::vector<std::unique_ptr<dds::Writer>> writers;
  std::vector<std::unique_ptr<dds::Reader>> readers;

  void add_writers(dds::Participant& p, const std::string& partition, Ear& ear) {
    for (const MessageClass cls : kTopics) {
      writers.push_back(p.writer(cls, partition, dds::Delivery::kEvery, ear.on_match()));
    }
  }
  void add_readers(dds::Participant& p, const std::string& partition, Ear& ear) {
    for (const MessageClass cls : kTopics) {
      readers.push_back(
          p.reader(cls, partition, dds::Delivery::kEvery, ear.on_message(), ear.on_match()));
    }
  }
  bool matched() const {
    const auto some = [](const auto& endpoint) { return endpoint->matched() > 0; };
    return std::all_of(writers.begin(), writers.end(), some) &&
           std::all_of(readers.begin(), readers.end(), some);
  }
  /// Topics without a partner, for messages.
  std::string unmatched() const {
    std::ostringstream all;
    const auto add = [&](const auto& endpoints, const char* kind) {
      for (std::size_t i = 0; i < endpoints.size(); ++i) {
        if (endpoints[i]->matched() == 0) {
          all << "; unmatched " << kind << ' ' << mission::topic_name(kTopics[i]);
        }
      }
    };
    add(writers, "writer");
    add(readers, "reader");
    return all.str();
  }
  void send_all(std::uint32_t src) {
    for (std::uint64_t n = 1; n <= kPerTopic; ++n) {
      for (int i = 0; i < kTopicCount; ++i) {
        writers[static_cast<std::size_t>(i)]->write(content(kTopics[i], src, n));
      }
    }
  }
  void send_ready(std::uint32_t src) {
    for (int i = 0; i < kTopicCount; ++i) {
      mission::ExchangeEnd ready;
      ready.envelope.src = RobotId{src};
      writers[static_cast<std::size_t>(i)]->write(dds::encode(ready).cdr);
    }
  }
};

void say(const std::string& line) { std::cout << line << std::endl; }

/// Ends the process at once: whoever waits for our next line must not wait for ever.
[[noreturn]] void fail(const std::string& what) {
  say("failed: " + what);
  std::_Exit(1);
}

int run_agent(dds::Participant& participant, std::uint32_t number) {
  Ear ear({0});
  Link link, stray;
  try {
    link.add_writers(participant, dds::up_partition(RobotId{number}), ear);
    link.add_readers(participant, dds::down_partition(RobotId{number}), ear);
    stray.add_writers(participant, "else." + std::to_string(number), ear);  // nobody must hear this
    ear.wait("the hub", [&] { return link.matched(); });
    ear.repeat(
        "the hub's ready", [&] { link.send_ready(number); }, [&] { return ear.ready(0); });
    stray.send_ready(kIntruder);
    link.send_all(number);
    ear.wait("the hub's messages", [&] { return ear.complete(0); });
  } catch (const Failure& e) {
    fail("agent " + std::to_string(number) + " " + e.what() + link.unmatched());
  }
  say("complete");
  std::string line;
  std::getline(std::cin, line);
  return 0;
}

/// One agent's share of the hub's work, in a thread of its own: also late joiners are served at
/// once.
void serve(dds::Participant& participant, Ear& ear, std::uint32_t agent) {
  Link link;
  try {
    link.add_writers(participant, dds::down_partition(RobotId{agent}), ear);
    ear.wait("ready", [&] { return link.matched() && ear.ready(agent); });
    // An agent begins when it has heard our ready on every topic.
    ear.repeat(
        "the agent to begin", [&] { link.send_ready(0); }, [&] { return ear.begun(agent); });
    link.send_all(0);
    ear.wait("messages", [&] { return ear.complete(agent); });
    say("complete " + std::to_string(agent));
    ear.wait_for_close();
  } catch (const Failure& e) {
    fail("hub for agent " + std::to_string(agent) + " " + e.what() + link.unmatched());
  }
}

int run_hub(dds::Participant& participant, const std::set<std::uint32_t>& agents) {
  Ear ear(agents);
  Link link;
  link.add_readers(participant, "up.*", ear);
  say("open");
  std::vector<std::future<void>> served;
  served.reserve(agents.size());
  for (const std::uint32_t agent : agents) {
    served.push_back(
        std::async(std::launch::async, [&, agent] { serve(participant, ear, agent); }));
  }
  std::string line;
  std::getline(std::cin, line);
  ear.close();
  for (auto& s : served) s.get();
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 5) throw Failure("wire_peer VENDOR DOMAIN hub AGENT[,AGENT...] | agent NUMBER");
  std::set<std::uint32_t> numbers;
  std::stringstream list(argv[4]);
  for (std::string one; std::getline(list, one, ',');) {
    numbers.insert(static_cast<std::uint32_t>(std::stoul(one)));
  }
  const bool hub = std::string(argv[3]) == "hub";
  dds::ParticipantConfig config;
  config.vendor = dds::vendor_from(argv[1]);
  config.domain = static_cast<std::uint32_t>(std::stoul(argv[2]));
  config.participant = hub ? 0 : *numbers.begin();
  const auto participant = dds::make_participant(config);
  return hub ? run_hub(*participant, numbers) : run_agent(*participant, config.participant);
} catch (const std::exception& e) {
  std::cout << "failed: " << e.what() << std::endl;
  return 1;
}
