#include "commsim/world/run_control.h"

#include <algorithm>

#include "commsim/world/flight.h"

namespace muster::world {

RunControl::RunControl(int fd) : channel_(fd), connected_(fd >= 0) {
  if (connected_) thread_ = std::thread([this] { listen(); });
}

RunControl::~RunControl() {
  if (!connected_) return;
  channel_.shut_down();
  if (thread_.joinable()) thread_.join();
}

void RunControl::listen() {
  while (const auto line = channel_.read_line()) {
    const auto message = nlohmann::json::parse(*line);
    const std::lock_guard lock(mutex_);
    if (message.contains("dead")) {
      const RobotId robot{message["dead"].get<std::uint32_t>()};
      dead_.emplace_back(robot, message.value("how", "ended"));
      if (dead_call_) dead_call_(robot);
    } else if (message.contains("request")) {
      const auto verb = verb_from(message["request"].get<std::string>());
      if (verb) requests_.emplace_back(*verb, RobotId{message.value("robot", kNoRobot.value)});
    } else if (message.contains("stop")) {
      stop_reason_ = message["stop"].get<std::string>();
      if (stop_call_) stop_call_(stop_reason_);
    }
  }
}

void RunControl::on_dead(std::function<void(RobotId)> call) {
  const std::lock_guard lock(mutex_);
  dead_call_ = std::move(call);
  if (!dead_call_) return;
  for (const auto& [robot, how] : dead_) dead_call_(robot);
}

void RunControl::on_stop(std::function<void(const std::string&)> call) {
  const std::lock_guard lock(mutex_);
  stop_call_ = std::move(call);
  if (stop_call_ && !stop_reason_.empty()) stop_call_(stop_reason_);
}

void RunControl::tell(const nlohmann::json& message) {
  if (connected_) channel_.write_line(message.dump());
}

std::vector<std::pair<mission::RequestVerb, RobotId>> RunControl::take_requests() {
  const std::lock_guard lock(mutex_);
  return std::exchange(requests_, {});
}

std::vector<RobotId> RunControl::take_dead() {
  const std::lock_guard lock(mutex_);
  std::vector<RobotId> robots;
  for (; dead_taken_ < dead_.size(); ++dead_taken_) robots.push_back(dead_[dead_taken_].first);
  return robots;
}

std::string RunControl::how_lost(RobotId robot) {
  const std::lock_guard lock(mutex_);
  const auto last =
      std::find_if(dead_.rbegin(), dead_.rend(), [&](const auto& d) { return d.first == robot; });
  return last == dead_.rend() ? "ended" : last->second;
}

std::string RunControl::stop_reason() {
  const std::lock_guard lock(mutex_);
  return stop_reason_;
}

void RunControl::await_hang_up() {
  if (thread_.joinable()) thread_.join();
}

}  // namespace muster::world
