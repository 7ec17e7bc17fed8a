#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>

#include "common/core/error.h"
#include "common/dds/convert.h"
#include "common/dds/participant.h"
#include "deploy/muster/doctor.h"

namespace muster::command {
namespace {

using Verdict = Check::Verdict;
using dds::Delivery;
using dds::Vendor;
using mission::MessageClass;

constexpr const char* kTopic = "DDS";
/// Star discovery on loopback takes half a second for fifty (DDS notes); a busy computer gets ten
/// times that.
constexpr std::chrono::seconds kPatience{5};

/// The library as it is loaded, which may be another than was compiled against: "2.9.1" out of
/// ".../libfastrtps.so.2.9.1".
std::string loaded_version(const std::string& library) {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const std::size_t at = line.find("/" + library + ".so.");
    if (at != std::string::npos) return line.substr(at + library.size() + 5);
  }
  return "";
}

std::uint32_t free_domain() {
  const std::vector<std::uint32_t> taken = taken_domains();
  for (std::uint32_t d = 99; d > 0; --d) {
    if (std::find(taken.begin(), taken.end(), d) == taken.end()) return d;
  }
  throw Failure("no DDS domain is free");
}

dds::ParticipantConfig on(Vendor vendor, std::uint32_t domain, std::uint32_t participant) {
  dds::ParticipantConfig config;
  config.vendor = vendor;
  config.domain = domain;
  config.participant = participant;
  return config;
}

/// One end of the trial: says `word` on one partition, listens on another.
class End {
 public:
  End(Vendor vendor, std::uint32_t domain, std::uint32_t participant, const std::string& says,
      const std::string& hears)
      : participant_(dds::make_participant(on(vendor, domain, participant))) {
    const auto wake = [this] {
      const std::lock_guard lock(mutex_);
      changed_.notify_all();
    };
    writer_ = participant_->writer(MessageClass::kOperatorRequest, says, Delivery::kEvery, wake);
    reader_ = participant_->reader(
        MessageClass::kOperatorRequest, hears, Delivery::kEvery,
        [this](mission::Message&&) {
          const std::lock_guard lock(mutex_);
          heard_ = true;
          changed_.notify_all();
        },
        wake);
  }
  bool await_match() {
    const auto until = std::chrono::steady_clock::now() + kPatience;
    // `matched` is asked without the lock: the middleware may hold its own while it calls us.
    while (writer_->matched() == 0 || reader_->matched() == 0) {
      if (std::chrono::steady_clock::now() > until) return false;
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, std::chrono::milliseconds(20));
    }
    return true;
  }
  void say() { writer_->write(dds::encode(mission::OperatorRequest{}).cdr); }
  bool await_word() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [this] { return heard_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool heard_ = false;
  std::unique_ptr<dds::Participant> participant_;
  std::unique_ptr<dds::Writer> writer_;
  std::unique_ptr<dds::Reader> reader_;
};

Check meet(Vendor hub_vendor, Vendor agent_vendor, std::uint32_t domain) {
  const std::string who = std::string(dds::to_string(hub_vendor)) + " hub and " +
                          dds::to_string(agent_vendor) + " agent ";
  const std::string help =
      "a firewall on loopback? see the buffers and interfaces above, and `ss -ulpn`";
  try {
    End hub(hub_vendor, domain, 0, "doctor.down", "doctor.up"),
        agent(agent_vendor, domain, 1, "doctor.up", "doctor.down");
    if (!hub.await_match() || !agent.await_match())
      return {kTopic, who + "did not find each other within 5 s", Verdict::kBad, help};
    hub.say();
    agent.say();
    if (!hub.await_word() || !agent.await_word())
      return {kTopic, who + "found each other, but a message got lost", Verdict::kBad, help};
    return {kTopic, who + "meet and talk", Verdict::kGood, ""};
  } catch (const std::exception& e) {
    return {kTopic, who + "failed: " + e.what(), Verdict::kBad, help};
  }
}

}  // namespace

Checks check_vendors() {
  Checks checks;
  for (const auto& [name, library] :
       {std::pair{"cyclonedds", "libddsc"}, std::pair{"fastdds", "libfastrtps"}}) {
    const std::string version = loaded_version(library);
    if (version.empty()) {
      checks.push_back({kTopic, std::string(name) + ": " + library + " is not loaded",
                        Verdict::kBad, "install the package again"});
    } else {
      checks.push_back({kTopic, std::string(name) + " " + version, Verdict::kGood, ""});
    }
  }
  return checks;
}

Checks check_matching() {
  Checks checks;
  try {
    for (const Vendor hub : {Vendor::kCyclone, Vendor::kFast}) {
      for (const Vendor agent : {Vendor::kCyclone, Vendor::kFast})
        checks.push_back(meet(hub, agent, free_domain()));
    }
  } catch (const Failure& e) {
    checks.push_back({kTopic, e.what(), Verdict::kBad, "`ss -ulpn` names who has the ports"});
  }
  return checks;
}

}  // namespace muster::command
