#pragma once

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "tests/text_of.h"

// For tests of whole programs.
namespace muster::test {

/// A directory of this process's own, removed at the end. One at a time.
struct Place {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / fmt::format("muster-test-{}", getpid());
  Place() { std::filesystem::create_directories(path); }
  ~Place() { std::filesystem::remove_all(path); }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  std::string operator/(const std::string& name) const { return path / name; }
};

struct Ended {
  int status = -1;
  std::string output;  ///< stdout and stderr
};

/// A shell command, until it has ended.
inline Ended shell(const std::string& line) {
  FILE* pipe = popen((line + " 2>&1").c_str(), "r");
  if (!pipe) throw std::runtime_error("no shell could be started");
  Ended ended;
  std::array<char, 4096> chunk;
  while (const std::size_t n = fread(chunk.data(), 1, chunk.size(), pipe))
    ended.output.append(chunk.data(), n);
  ended.status = WEXITSTATUS(pclose(pipe));
  return ended;
}

/// A program in the background: a command as a shell reads it. Whoever starts it reaps it.
inline pid_t start(const std::string& line) {
  const pid_t pid = fork();
  if (pid != 0) return pid;
  execl("/bin/sh", "sh", "-c", ("exec " + line).c_str(), nullptr);
  _exit(127);
}

/// Of a run.
inline nlohmann::json summary_of(const std::filesystem::path& out) {
  return nlohmann::json::parse(std::ifstream(out / "summary.json"));
}

}  // namespace muster::test
