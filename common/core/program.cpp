#include "common/core/program.h"

#include <malloc.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "common/core/error.h"

namespace muster {
namespace {

/// A process holds a dozen DDS threads that hardly ever allocate at the same time: an arena of
/// 64 MB each, and freed megabytes that are kept, are what fifty processes do not have.
void spare_memory() {
#ifdef __GLIBC__
  mallopt(M_ARENA_MAX, 2);
  mallopt(M_MMAP_THRESHOLD, 256 * 1024);
  mallopt(M_TRIM_THRESHOLD, 1024 * 1024);
#endif
}

}  // namespace

int run_program(const char* name, const std::function<int()>& body) {
  spare_memory();
  try {
    return body();
  } catch (const BadInput& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
    return kExitBadInput;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
    return kExitFailure;
  }
}

void end_with_launcher() {
  const char* launcher = std::getenv(kLauncherVariable);
  if (!launcher) return;
  std::signal(SIGINT, SIG_IGN);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // The launcher may have died before the line above: then nobody would ever tell us.
  if (getppid() != static_cast<pid_t>(std::atol(launcher))) std::_Exit(kExitFailure);
}

}  // namespace muster
