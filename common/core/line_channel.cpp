#include "common/core/line_channel.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

namespace muster {

LineChannel::~LineChannel() {
  if (fd_ >= 0) ::close(fd_);
}

bool LineChannel::take_line(std::string& line) {
  const auto end = buffer_.find('\n');
  if (end == std::string::npos) return false;
  line = buffer_.substr(0, end);
  buffer_.erase(0, end + 1);
  return true;
}

bool LineChannel::fill() {
  char chunk[65536];
  ssize_t n = 0;
  do {
    n = ::read(fd_, chunk, sizeof chunk);
  } while (n < 0 && errno == EINTR);
  if (n <= 0) return false;
  buffer_.append(chunk, static_cast<std::size_t>(n));
  return true;
}

std::optional<std::string> LineChannel::read_line() {
  std::string line;
  while (!take_line(line)) {
    if (!fill()) return std::nullopt;
  }
  return line;
}

std::vector<std::string> LineChannel::read_available(bool& closed) {
  closed = !fill();
  std::vector<std::string> lines;
  for (std::string line; take_line(line);) lines.push_back(std::move(line));
  return lines;
}

bool LineChannel::write_line(std::string_view line) {
  const std::lock_guard lock(write_mutex_);
  std::string text(line);
  text += '\n';
  std::size_t at = 0;
  while (at < text.size()) {
    const ssize_t n = ::send(fd_, text.data() + at, text.size() - at, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += static_cast<std::size_t>(n);
  }
  return true;
}

void LineChannel::end_writing() { ::shutdown(fd_, SHUT_WR); }

void LineChannel::shut_down() { ::shutdown(fd_, SHUT_RDWR); }

}  // namespace muster
