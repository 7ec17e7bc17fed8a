#include "deploy/muster/interrupt.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>

#include "common/core/error.h"

namespace muster::command {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t g_wished = 0;
int g_fd = -1;

void on_signal(int signal) {
  if (g_wished) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
    return;
  }
  g_wished = 1;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(g_fd, &one, sizeof one);
}

}  // namespace

Interrupt::Interrupt() {
  g_wished = 0;
  g_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (g_fd < 0) throw Failure("cannot make an eventfd");
  struct sigaction action {};
  action.sa_handler = on_signal;
  for (int signal : kSignals) sigaction(signal, &action, nullptr);
}

Interrupt::~Interrupt() {
  for (int signal : kSignals) std::signal(signal, SIG_DFL);
  ::close(g_fd);
  g_fd = -1;
}

bool Interrupt::wished() const { return g_wished != 0; }
int Interrupt::fd() const { return g_fd; }

}  // namespace muster::command
