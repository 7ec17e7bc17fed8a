#include "deploy/muster/write_file.h"

#include <filesystem>
#include <fstream>

#include "common/core/error.h"

namespace muster::command {

void write_file(const std::string& path, const std::string& content) {
  const std::string aside = path + ".new";
  std::ofstream file(aside, std::ios::binary);
  file << content;
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(aside, path, error);
  if (!file || error) throw Failure(path + ": cannot be written");
}

}  // namespace muster::command
