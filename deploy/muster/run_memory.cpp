#include "deploy/muster/run_memory.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "common/core/cpu_time.h"
#include "common/core/error.h"
#include "common/core/log.h"
#include "commsim/world/pacer.h"
#include "deploy/muster/control_socket.h"
#include "deploy/muster/interrupt.h"
#include "deploy/muster/memory_fleet.h"
#include "deploy/muster/progress.h"
#include "deploy/muster/run_results.h"
#include "deploy/muster/summary.h"

namespace muster::command {
namespace {

/// Requests from the socket's thread, taken between ticks.
class RequestQueue {
 public:
  explicit RequestQueue(const mission::Mission& mission) : mission_(mission) {}

  std::string put(mission::RequestVerb verb, RobotId robot) {
    if (robot != kNoRobot && !mission_.has(robot))
      return fmt::format("the mission has no robot {}", robot.value);
    const std::lock_guard lock(mutex_);
    waiting_.emplace_back(verb, robot);
    return "ok";
  }
  std::vector<std::pair<mission::RequestVerb, RobotId>> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waiting_, {});
  }

 private:
  const mission::Mission& mission_;
  std::mutex mutex_;
  std::vector<std::pair<mission::RequestVerb, RobotId>> waiting_;
};

/// What is wrong with a site may come to light only when its features are drawn.
std::unique_ptr<MemoryFleet> make_fleet(const mission::Mission& mission,
                                        const std::shared_ptr<const world::Scene>& scene,
                                        const RunOptions& options) {
  const world::FlightConfig flight{
      .out = options.out, .duration_s = options.duration_s, .trace = options.trace};
  try {
    return std::make_unique<MemoryFleet>(mission, scene, make_process, flight);
  } catch (const BadInput&) {
    if (options.out_is_new) remove_results(options.out, false);
    throw;
  }
}

}  // namespace

int run_in_memory(const mission::Mission& mission, const std::shared_ptr<const world::Scene>& scene,
                  const RunOptions& options) {
  const Interrupt interrupt;
  RequestQueue requests(mission);
  const ControlSocket socket(options.out,
                             [&](auto verb, RobotId robot) { return requests.put(verb, robot); });
  log::open(options.out + "/logs", "fleet");
  const auto begin = std::chrono::steady_clock::now();
  const std::unique_ptr<MemoryFleet> made = make_fleet(mission, scene, options);
  MemoryFleet& fleet = *made;
  Progress progress(Progress::form_for(options.json));
  const world::Pacer pacer(options.speed_factor());

  const auto start = std::chrono::steady_clock::now();
  const double cpu_start_s = cpu_of_process_s();
  std::optional<std::string> end;
  while (!end) {
    log::set_speaker(time_of_tick(fleet.ticks()), kNoRobot);
    for (const auto& [verb, robot] : requests.take()) fleet.flight().request(verb, robot);
    end = fleet.tick();
    if (fleet.ticks() % 10 == 1) progress.show(fleet.flight().progress());
    if (interrupt.wished() && !end) end = "interrupted";
    pacer.wait_until(time_of_tick(fleet.ticks()));
  }
  const double cpu_s = cpu_of_process_s() - cpu_start_s;
  const double load_s = std::chrono::duration<double>(start - begin).count();
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  nlohmann::json summary = fleet.finish(*end);
  summary["dds"] = nullptr;
  summary["transport"] = "memory";
  summary["load_s"] = load_s;
  add_cost(summary, {.wall_s = wall_s, .cpu_s = cpu_s, .agent_rss_mb = {}, .station_rss_mb = {}},
           mission.fleet.size());
  finish_results(options, summary);
  progress.result(summary, options.out);
  return exit_status(summary);
}

}  // namespace muster::command
