#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/core/ids.h"
#include "common/core/line_channel.h"
#include "common/mission/messages.h"
#include "commsim/world/hub_options.h"

namespace muster::world {

/// How a process of `muster-world` is asked to run.
struct RunnerOptions : HubOptions {
  double duration_s = 0;
  double speed = 0;      ///< 0: as fast as possible
  bool trace = false;    ///< write trace.csv
  double restart_s = 0;  ///< who died by itself is started again after so long; 0: never
};

/// The world's end of the conversation with `muster run`, one JSON object a line:
///
///     to us    {"dead": id, "how": text}   {"request": verb, "robot": id}   {"stop": reason}   end
///     of stream: go
///     from us  {"matched": true}  {"started": true, "load_s": …}  {"progress": …}  {"kill": id}
///     {"revive": id, "life": n, "journal_lost": bool}  {"summary": …}  {"failed": text, "bad_input": bool}
class RunControl {
 public:
  explicit RunControl(int fd);
  ~RunControl();
  RunControl(const RunControl&) = delete;
  RunControl& operator=(const RunControl&) = delete;

  /// Called on the listening thread, before the request itself is put aside.
  void on_dead(std::function<void(RobotId)> call);
  void on_stop(std::function<void(const std::string&)> call);

  void tell(const nlohmann::json& message);
  std::vector<std::pair<mission::RequestVerb, RobotId>> take_requests();
  /// Robots whose process ended, since the last call.
  std::vector<RobotId> take_dead();
  /// How the process of a lost robot ended.
  std::string how_lost(RobotId robot);
  /// Why we shall stop; empty: go on.
  std::string stop_reason();
  /// Waits until `muster run` hangs up, which it does when everybody has ended. At once when nobody
  /// started us.
  void await_hang_up();

 private:
  void listen();

  LineChannel channel_;
  const bool connected_;
  std::mutex mutex_;
  std::function<void(RobotId)> dead_call_;
  std::function<void(const std::string&)> stop_call_;
  std::vector<std::pair<mission::RequestVerb, RobotId>> requests_;
  std::vector<std::pair<RobotId, std::string>> dead_;
  std::size_t dead_taken_ = 0;
  std::string stop_reason_;
  std::thread thread_;
};

}  // namespace muster::world
