#include "deploy/muster/control_socket.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <optional>
#include <sstream>
#include <utility>

#include "common/core/error.h"
#include "common/core/line_channel.h"
#include "commsim/world/flight.h"

namespace muster::command {
namespace {

constexpr const char* kName = "ctl.sock";

/// A unix socket's address holds 107 characters, a directory's path may be longer: so it is named
/// through an open descriptor of DIR.
class Address {
 public:
  explicit Address(const std::string& dir)
      : dir_fd_(open(dir.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)) {
    if (dir_fd_ < 0) throw Failure(dir + ": is not a directory that can be opened");
    address_.sun_family = AF_UNIX;
    const std::string path = "/proc/self/fd/" + std::to_string(dir_fd_) + "/" + kName;
    std::strncpy(address_.sun_path, path.c_str(), sizeof address_.sun_path - 1);
  }
  ~Address() { ::close(dir_fd_); }
  Address(const Address&) = delete;
  Address& operator=(const Address&) = delete;

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&address_); }
  static constexpr socklen_t size() { return sizeof(sockaddr_un); }

 private:
  int dir_fd_;
  sockaddr_un address_{};
};

int new_socket() {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) throw Failure("cannot make a unix socket");
  return fd;
}

}  // namespace

ControlSocket::ControlSocket(const std::string& dir, OnRequest on_request)
    : path_(dir + "/" + kName), on_request_(std::move(on_request)), fd_(new_socket()) {
  const Address address(dir);
  {
    const LineChannel probe(new_socket());
    if (connect(probe.fd(), address.get(), Address::size()) == 0) {
      ::close(fd_);
      throw Failure("--out: " + dir + ": another run is using this directory");
    }
  }
  unlink(path_.c_str());
  if (bind(fd_, address.get(), Address::size()) != 0 || listen(fd_, 4) != 0) {
    ::close(fd_);
    throw Failure(path_ + ": cannot be made: " + std::strerror(errno));
  }
  thread_ = std::thread([this] { serve(); });
}

ControlSocket::~ControlSocket() {
  shutdown(fd_, SHUT_RDWR);
  thread_.join();
  ::close(fd_);
  unlink(path_.c_str());
}

void ControlSocket::serve() {
  while (true) {
    const int connection = accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC);
    if (connection < 0) return;
    // A client that connects and says nothing must not keep the others waiting.
    const timeval patience{2, 0};
    setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    LineChannel channel(connection);
    if (const auto line = channel.read_line()) channel.write_line(answer(*line));
  }
}

std::string ControlSocket::answer(const std::string& line) const {
  std::istringstream words(line);
  std::string verb_name;
  words >> verb_name;
  const auto verb = world::verb_from(verb_name);
  if (!verb) return "'" + verb_name + "' is not one of hold, resume, return, land, abort";
  RobotId robot = kNoRobot;
  words >> robot.value;
  return on_request_(*verb, words ? robot : kNoRobot);
}

void send_request(const std::string& dir, const std::string& verb, RobotId robot) {
  if (!world::verb_from(verb))
    throw BadInput("'" + verb + "' is not one of hold, resume, return, land, abort");
  const Address address(dir);
  LineChannel channel(new_socket());
  if (connect(channel.fd(), address.get(), Address::size()) != 0)
    throw Failure(dir + ": no run is going on here");
  channel.write_line(robot == kNoRobot ? verb : verb + " " + std::to_string(robot.value));
  const auto answer = channel.read_line();
  if (!answer) throw Failure(dir + ": the run ended before it answered");
  if (*answer != "ok") throw BadInput(*answer);
}

}  // namespace muster::command
