#pragma once

namespace muster {

/// CPU time that this process has used so far, all its threads together. For reports only.
double cpu_of_process_s();

}  // namespace muster
