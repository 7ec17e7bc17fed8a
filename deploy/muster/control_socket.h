#pragma once

#include <functional>
#include <string>
#include <thread>

#include "common/core/ids.h"
#include "common/mission/messages.h"

namespace muster::command {

/// DIR/ctl.sock, where `muster ctl` reaches a running `muster run`. One request is one line,
/// "abort" or "hold 3"; the answer is one line, "ok" or what is wrong with it.
class ControlSocket {
 public:
  /// Called on a thread of its own; returns the answer.
  using OnRequest = std::function<std::string(mission::RequestVerb, RobotId)>;

  /// Throws Failure when the socket cannot be made, or another run is using this directory.
  ControlSocket(const std::string& dir, OnRequest on_request);
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

 private:
  void serve();
  std::string answer(const std::string& line) const;

  std::string path_;
  OnRequest on_request_;
  int fd_ = -1;
  std::thread thread_;
};

/// `muster ctl DIR VERB [--robot ID]`. Throws BadInput for an unknown verb or robot, Failure when
/// no run listens there.
void send_request(const std::string& dir, const std::string& verb, RobotId robot);

}  // namespace muster::command
