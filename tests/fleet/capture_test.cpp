// A real capture of each vendor's packets, read by tshark with muster.lua: every byte of every kind
// of message is shown by a field of that name.
#include "deploy/muster/capture.h"

#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/dds/convert.h"
#include "common/dds/participant.h"
#include "tests/free_domain.h"
#include "tests/unit/dds/samples.h"

namespace fs = std::filesystem;

using namespace muster;
using mission::Message;
using mission::MessageClass;

namespace {

/// What a shell command prints.
std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  REQUIRE(pipe);
  std::string text;
  std::array<char, 65'536> part{};
  for (std::size_t n = 0; (n = fread(part.data(), 1, part.size(), pipe.get())) > 0;)
    text.append(part.data(), n);
  return text;
}

bool tshark_is_here() { return !output_of("command -v tshark").empty(); }

template <class T>
Message record_of(test::Samples& samples, store::RecordClass cls, const T& body) {
  const store::Record record = dds::encode_record(samples.header(cls), body);
  return dds::wrap(samples.envelope(mission::message_class(cls)), record);
}

/// One message of every kind with something in every field; an image that takes fragments.
std::vector<Message> one_of_each() {
  using namespace mission;
  test::Samples s(5);
  Inspection image = s.make<Inspection>();
  image.payload.assign(200'001, 0xA7);
  return {dds::encode(s.make<Beacon>()),
          record_of(s, store::RecordClass::kMap, s.make<MapBlock>()),
          record_of(s, store::RecordClass::kArea, s.make<Area>()),
          record_of(s, store::RecordClass::kInspection, image),
          record_of(s, store::RecordClass::kPlan, s.make<Plan>()),
          record_of(s, store::RecordClass::kMeeting, s.make<Meeting>()),
          record_of(s, store::RecordClass::kStatus, s.make<Status>()),
          dds::encode(s.make<ExchangeEnd>()),
          dds::encode(s.make<Odometry>()),
          dds::encode(s.make<Scan>()),
          dds::encode(s.make<Sightings>()),
          dds::encode(s.make<Battery>()),
          dds::encode(s.make<Inspected>()),
          dds::encode(s.make<OperatorRequest>()),
          dds::encode(s.make<Trajectory>()),
          dds::encode(s.make<Inspect>()),
          dds::encode(s.make<Charge>()),
          dds::encode(s.make<Tick>()),
          dds::encode(s.make<Done>()),
          dds::encode(s.make<Truth>())};
}

/// Sends them from a participant of this vendor to one of the other, because two of one vendor in
/// one process need no packets, and waits until all are there.
void send(dds::Vendor vendor, std::uint32_t domain, const std::vector<Message>& messages) {
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t heard = 0;
  const auto config = [&](dds::Vendor v, std::uint32_t participant) {
    dds::ParticipantConfig c;
    c.vendor = v;
    c.domain = domain;
    c.participant = participant;
    return c;
  };
  const auto other = vendor == dds::Vendor::kFast ? dds::Vendor::kCyclone : dds::Vendor::kFast;
  const auto hub = dds::make_participant(config(other, 0));
  const auto agent = dds::make_participant(config(vendor, 1));
  const auto notify = [&] {
    const std::lock_guard lock(mutex);
    changed.notify_all();
  };
  std::vector<std::unique_ptr<dds::Reader>> readers;
  std::vector<std::unique_ptr<dds::Writer>> writers;
  for (const Message& m : messages) {
    readers.push_back(hub->reader(
        m.cls, "up.*", dds::Delivery::kEvery,
        [&](Message&&) {
          const std::lock_guard lock(mutex);
          ++heard;
          changed.notify_all();
        },
        notify));
    writers.push_back(agent->writer(m.cls, "up.1", dds::Delivery::kEvery, notify));
  }
  std::unique_lock lock(mutex);
  const auto matched = [&] {
    for (std::size_t i = 0; i < messages.size(); ++i) {
      if (readers[i]->matched() < 1 || writers[i]->matched() < 1) return false;
    }
    return true;
  };
  REQUIRE(changed.wait_for(lock, std::chrono::seconds(60), matched));
  lock.unlock();
  for (std::size_t i = 0; i < messages.size(); ++i) writers[i]->write(messages[i].cdr);
  lock.lock();
  REQUIRE(
      changed.wait_for(lock, std::chrono::seconds(60), [&] { return heard >= messages.size(); }));
}

struct Shown {
  std::string name, show;
  Bytes value;
};
/// What tshark shows of one message: its fields in order, and what it says about it.
struct Dissected {
  std::map<std::string, std::string> about;  ///< type, topic, partition, bytes, fragments
  std::vector<Shown> fields;
};

std::string attribute(const std::string& line, const std::string& key) {
  const std::size_t at = line.find(' ' + key + "=\"");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + key.size() + 3;
  return line.substr(begin, line.find('"', begin) - begin);
}

Bytes from_hex(const std::string& hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

std::vector<Dissected> dissect(const fs::path& capture) {
  static const std::set<std::string> kAbout{"type",  "topic",     "partition",
                                            "bytes", "fragments", "malformed"};
  std::istringstream pdml(output_of(
      fmt::format("tshark -r '{}' -X lua_script:'{}' -T pdml 2>&1", capture.string(), MUSTER_LUA)));
  std::vector<Dissected> all;
  for (std::string line; std::getline(pdml, line);) {
    const std::string name = attribute(line, "name");
    if (!name.starts_with("muster.")) continue;
    const std::string field = name.substr(7);
    if (field == "type") all.emplace_back();
    REQUIRE(!all.empty());
    if (kAbout.contains(field)) {
      all.back().about[field] = attribute(line, "show");
    } else {
      all.back().fields.push_back(
          {field, attribute(line, "show"), from_hex(attribute(line, "value"))});
    }
  }
  return all;
}

std::uint32_t word_at(const Bytes& cdr, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, cdr.data() + at, sizeof word);
  return word;
}

/// The fields, one behind the other, are the message: between them is only padding, and the lengths
/// of texts and byte sequences.
bool covers(const std::vector<Shown>& fields, const Bytes& cdr) {
  std::size_t at = 4;
  const auto is_here = [&](std::size_t where, const Bytes& value) {
    return where + value.size() <= cdr.size() &&
           std::equal(value.begin(), value.end(), cdr.begin() + static_cast<long>(where));
  };
  for (const Shown& field : fields) {
    bool found = false;
    for (std::size_t pad = 0; pad < 8 && at + pad <= cdr.size() && !found; ++pad) {
      const std::size_t here = at + pad, behind_length = here + 4;
      if (is_here(here, field.value)) {
        at = here + field.value.size();
        found = true;
      } else if (behind_length <= cdr.size() && word_at(cdr, here) == field.value.size() &&
                 is_here(behind_length, field.value)) {
        at = behind_length + field.value.size();
        found = true;
      }
      if (!found && here < cdr.size() && cdr[here] != 0) return false;  // that was no padding
    }
    if (!found) return false;
  }
  return cdr.size() - at < 4;
}

std::set<std::string> declared_fields() {
  std::istringstream list(
      output_of(fmt::format("tshark -G fields -X lua_script:'{}' 2>&1", MUSTER_LUA)));
  std::set<std::string> names;
  for (std::string line; std::getline(list, line);) {
    const std::size_t at = line.find("\tmuster.");
    if (at != std::string::npos)
      names.insert(line.substr(at + 8, line.find('\t', at + 1) - at - 8));
  }
  return names;
}

}  // namespace

TEST_CASE(
    "tshark shows every field of every message of both vendors, put together from fragments") {
  if (!tshark_is_here()) {
    WARN("skipped: tshark is not here (apt install tshark)");
    return;
  }
  const auto vendor = GENERATE(dds::Vendor::kCyclone, dds::Vendor::kFast);
  const fs::path file = fs::temp_directory_path() / fmt::format("muster_{}.pcapng", getpid());
  const std::uint32_t domain = test::free_domain();
  const std::vector<Message> sent = one_of_each();
  try {
    command::Capture capture(file.string(), domain);
    send(vendor, domain, sent);
    const auto outcome = capture.stop();
    CHECK(outcome.packets > sent.size());
    CHECK(outcome.missed == 0);
  } catch (const Failure& e) {
    if (std::string(e.what()).find("setcap") == std::string::npos) throw;
    WARN("skipped: " << e.what());
    return;
  }
  const std::vector<Dissected> seen = dissect(file);
  const std::set<std::string> declared = declared_fields();
  for (const Message& message : sent) {
    const std::string topic = mission::topic_name(message.cls);
    INFO(topic);
    const auto shown = std::find_if(
        seen.begin(), seen.end(), [&](const Dissected& d) { return d.about.at("topic") == topic; });
    REQUIRE(shown != seen.end());
    CHECK(shown->about.at("type") == mission::type_name(message.cls));
    CHECK(shown->about.at("partition") == "up.1");
    CHECK(shown->about.at("bytes") == std::to_string(message.cdr.size()));
    CHECK(shown->about.count("malformed") == 0);
    CHECK((shown->about.count("fragments") == 1) == (message.cls == MessageClass::kInspection));
    CHECK(covers(shown->fields, message.cdr));
    std::set<std::string> names, expected;
    for (const Shown& field : shown->fields) names.insert(field.name);
    for (const std::string& name : declared) {
      if (name.starts_with(topic + ".")) expected.insert(name);
    }
    CHECK(names == expected);
  }
  fs::remove(file);
}

TEST_CASE("what tshark shows is what was meant") {
  if (!tshark_is_here()) {
    WARN("skipped: tshark is not here (apt install tshark)");
    return;
  }
  const fs::path file = fs::temp_directory_path() / fmt::format("muster_m{}.pcapng", getpid());
  const std::uint32_t domain = test::free_domain();
  mission::Beacon beacon;
  beacon.envelope = {77, RobotId{3}, MessageClass::kBeacon, SimTime::from_s(12.5)};
  beacon.pose.p = Vec3(1.5, -2.25, 3);
  beacon.digest = {{{RobotId{9}, 4}, store::RecordClass::kArea, 6, {{8, 9}}}};
  test::Samples samples(1);
  mission::Status status = samples.make<mission::Status>();
  status.note = "all is well";
  const std::vector<Message> sent{dds::encode(beacon),
                                  record_of(samples, store::RecordClass::kStatus, status)};
  try {
    command::Capture capture(file.string(), domain);
    send(dds::Vendor::kCyclone, domain, sent);
    capture.stop();
  } catch (const Failure& e) {
    if (std::string(e.what()).find("setcap") == std::string::npos) throw;
    WARN("skipped: " << e.what());
    return;
  }
  std::map<std::string, std::string> values;
  for (const Dissected& d : dissect(file)) {
    for (const Shown& field : d.fields) values.try_emplace(field.name, field.show);
  }
  CHECK(values["beacon.envelope.n"] == "77");
  CHECK(values["beacon.envelope.src"] == "3");
  CHECK(values["beacon.envelope.sent_s"] == "12.5");
  CHECK(values["beacon.pose.p.y"] == "-2.25");
  CHECK(values["beacon.digest.count"] == "1");
  CHECK(values["beacon.digest.author"] == "9");
  CHECK(values["beacon.digest.beyond.last"] == "9");
  CHECK(values["status.note"] == "all is well");
  fs::remove(file);
}
