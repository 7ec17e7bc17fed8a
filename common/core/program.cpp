#include "common/core/program.h"

#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "common/core/error.h"

namespace muster {

int run_program(const char* name, const std::function<int()>& body) {
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
