#include "common/core/log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <atomic>
#include <memory>

#include "common/core/error.h"

namespace muster::log {
namespace {

std::atomic<std::int64_t> g_now_us{0};
std::atomic<std::uint32_t> g_speaker{kNoRobot.value};

/// `%*` in the pattern: mission time in seconds, and the robot that speaks.
class MissionTimeFlag : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg&, const std::tm&,
              spdlog::memory_buf_t& dest) override {
    std::string text =
        fmt::format("{:9.1f}", SimTime{g_now_us.load(std::memory_order_relaxed)}.s());
    const std::uint32_t speaker = g_speaker.load(std::memory_order_relaxed);
    if (speaker != kNoRobot.value) text += fmt::format(" robot {}", speaker);
    dest.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<MissionTimeFlag>();
  }
};

}  // namespace

void open(const std::string& dir, const std::string& name, Before before) {
  try {
    auto logger =
        spdlog::basic_logger_st(name, dir + "/" + name + ".log", before == Before::kForget);
    auto formatter = std::make_unique<spdlog::pattern_formatter>();
    formatter->add_flag<MissionTimeFlag>('*').set_pattern("%* %n %l: %v");
    logger->set_formatter(std::move(formatter));
    logger->flush_on(spdlog::level::info);  // a process that is killed says where it was
    spdlog::set_default_logger(std::move(logger));
  } catch (const spdlog::spdlog_ex& e) {
    throw Failure(dir + ": cannot write logs here: " + e.what());
  }
}

void set_time(SimTime now) { g_now_us.store(now.us, std::memory_order_relaxed); }

void set_speaker(SimTime now, RobotId robot) {
  set_time(now);
  g_speaker.store(robot.value, std::memory_order_relaxed);
}

}  // namespace muster::log
