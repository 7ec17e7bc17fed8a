#pragma once

#include <string>
#include <vector>

namespace muster::test {

/// What fastddsgen and idlc do not both understand, or what our wire does not want (idl/README.md).
/// One line per finding, `name:line: what`.
std::vector<std::string> lint_idl(const std::string& name, const std::string& text);

}  // namespace muster::test
