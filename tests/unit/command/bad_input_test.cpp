// What is wrong with what the user gave us, told by the real programs: one line that names the
// place and says what would be right, exit status 2 (or 1 where the surroundings are at fault),
// nobody left running, nothing half-written.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <limits>

#include "tests/free_domain.h"
#include "tests/programs.h"

namespace fs = std::filesystem;
using namespace muster::test;

namespace {

/// A folder for missions, with the scenes and vehicles that come with Muster beside it.
class Folder {
 public:
  Folder() {
    fs::create_directories(dir_ / "missions");
    for (const char* name : {"scenes", "vehicles"})
      fs::create_directory_symlink(fs::path(MUSTER_SOURCE_DIR) / "deploy" / name, dir_ / name);
  }
  ~Folder() { fs::remove_all(dir_); }
  std::string path(const std::string& name) const { return dir_ / name; }

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(dir_ / name, std::ios::binary) << bytes;
  }
  /// missions/m.yaml: `pagoda` with one thing changed.
  void write_mission(const std::string& from, const std::string& to) const {
    std::string mission = text_of(fs::path(MUSTER_SOURCE_DIR) / "deploy/missions/pagoda.yaml");
    const auto at = mission.find(from);
    REQUIRE(at != std::string::npos);
    write("missions/m.yaml", mission.replace(at, from.size(), to));
  }

  /// Runs one of our programs here. Its output without the folder's own name, and without the
  /// program's.
  Ended run(const std::string& program, const std::string& arguments) const {
    Ended ended = shell(fmt::format("cd '{}' && timeout 120 '{}/{}' {} </dev/null", dir_.string(),
                                    MUSTER_BIN_DIR, program, arguments));
    if (ended.output.starts_with(program + ": ")) ended.output.erase(0, program.size() + 2);
    const std::string here = dir_.string() + "/";
    for (auto at = ended.output.find(here); at != std::string::npos; at = ended.output.find(here))
      ended.output.erase(at, here.size());
    return ended;
  }

 private:
  fs::path dir_ = fs::temp_directory_path() / fmt::format("muster-bad-input-{}", getpid());
};

bool is_one_line(const std::string& text) {
  return std::count(text.begin(), text.end(), '\n') == 1 && text.back() == '\n';
}

/// Whoever names this output directory on the command line is one of ours.
bool somebody_runs_with(const std::string& out) {
  for (const auto& entry : fs::directory_iterator("/proc")) {
    if (text_of(entry.path() / "cmdline").find(out) != std::string::npos) return true;
  }
  return false;
}

/// `muster run` is told what is wrong before it has made or started anything.
void check_refused(const Folder& folder, const std::string& arguments, const std::string& complaint,
                   int status = 2) {
  for (const char* transport : {"dds", "memory"}) {
    INFO(arguments << " over " << transport);
    const Ended run =
        folder.run("muster", fmt::format("run {} --transport {} --out '{}'", arguments, transport,
                                         folder.path("refused")));
    INFO(run.output);
    CHECK(run.status == status);
    CHECK(run.output.starts_with(complaint));
    CHECK(is_one_line(run.output));
    CHECK_FALSE(fs::exists(folder.path("refused")));
    CHECK_FALSE(somebody_runs_with(folder.path("refused")));
  }
}

/// A box of 12 triangles around the origin, as binary STL.
std::string stl_of_a_box() {
  std::string bytes(80, ' ');
  const auto put = [&](const auto value) {
    const auto* raw = reinterpret_cast<const char*>(&value);
    bytes.append(raw, sizeof value);
  };
  put(std::uint32_t{12});
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.f, 1.f}) {
      for (const float turn : {-1.f, 1.f}) {
        for (int i = 0; i < 3; ++i) put(0.f);  // readers compute the normal
        for (const auto& [u, v] : {std::pair{-1.f, -1.f}, {1.f, 1.f}, {turn, -turn}}) {
          float corner[3];
          corner[axis] = side;
          corner[(axis + 1) % 3] = u;
          corner[(axis + 2) % 3] = v;
          for (const float x : corner) put(4 * x);
        }
        put(std::uint16_t{0});
      }
    }
  }
  return bytes;
}

}  // namespace

TEST_CASE("a mistake in a mission file is told with file, line and key") {
  const Folder folder;
  const auto refused = [&](const std::string& from, const std::string& to,
                           const std::string& complaint) {
    folder.write_mission(from, to);
    check_refused(folder, "missions/m.yaml", complaint);
  };
  refused(
      "time_limit_s:", "time_limit:", "missions/m.yaml:14: time_limit: unknown key; known here: ");
  refused("standing: {", "standing: [", "missions/m.yaml:13: not YAML: ");
  refused("scenes/pagoda.yaml", "scenes/pagado.yaml",
          "missions/m.yaml:2: scene: there is no file '../scenes/pagado.yaml'");
  refused("first_id: 3", "first_id: 2",
          "missions/m.yaml:10: fleet[2].first_id: robot 2 is there twice");
  refused("time_limit_s:", "strategy: slei4d\ntime_limit_s:",
          "missions/m.yaml:14: strategy: 'slei4d' is not one of slei3d");
}

TEST_CASE("a fleet without a station is refused") {
  const Folder folder;
  folder.write_mission(
      "  - {role: station, vehicle: ugv-station, first_id: 1, starts: [[0, 11, 0.4, -90]]}\n", "");
  check_refused(folder, "missions/m.yaml", "missions/m.yaml:8: fleet: a fleet needs a station");
}

TEST_CASE("a mission that does not fit its scene is told with file, line and key") {
  const Folder folder;
  folder.write_mission("boxes:\n", "boxes:\n  - {low: [-9, 12, 15.9], high: [-7, 15, 16.8]}\n");
  check_refused(folder, "missions/m.yaml",
                "missions/m.yaml:5: boxes[0]: lies outside the scene, which is x ");
  folder.write_mission("starts: [[0, 12.3, 1, -90]]", "starts: [[0, 0, 1, -90]]");
  check_refused(
      folder, "missions/m.yaml",
      "missions/m.yaml:9: fleet[1].starts: robot 2 at (0.00, 0.00, 1.00) starts inside a wall; ");
}

TEST_CASE("a mesh that cannot be trusted is refused by its name") {
  const Folder folder;
  const std::string whole = stl_of_a_box();
  folder.write_mission("../scenes/pagoda.yaml", "../box.stl\nground: true");
  folder.write("box.stl", whole.substr(0, whole.size() / 2));
  check_refused(folder, "missions/m.yaml",
                "box.stl: cut short: 12 triangles need 684 bytes, there are 342");
  std::string broken = whole;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  broken.replace(84 + 50 * 3 + 12, sizeof nan, reinterpret_cast<const char*>(&nan), sizeof nan);
  folder.write("box.stl", broken);
  check_refused(folder, "missions/m.yaml", "box.stl: vertex ");
  CHECK(folder.run("muster", "scene info box.stl").status == 2);
  CHECK(is_one_line(folder.run("muster", "scene info box.stl").output));
  folder.write("box.stl", whole);
  CHECK(folder.run("muster", "scene info box.stl").status == 0);
}

TEST_CASE("options that name nothing are refused") {
  const Folder folder;
  folder.write_mission("standing", "standing");
  check_refused(folder, "nowhere.yaml", "nowhere.yaml: cannot be read");
  check_refused(folder, "missions", "missions: is a directory; a YAML file is expected");
  check_refused(folder, "missions/m.yaml --dds opendds",
                "--dds: opendds not in {cyclonedds,fastdds,mixed}");
  check_refused(folder, "missions/m.yaml --strategy slei4d",
                "--set strategy=slei4d: strategy: 'slei4d'");
  check_refused(folder, "missions/m.yaml --set radio.rnge_m=3",
                "--set radio.rnge_m=3: radio.rnge_m: unknown key");
  check_refused(folder, "missions/m.yaml --domain many", "Could not convert: --domain = many");
}

TEST_CASE("what is only found out while everybody starts ends the run in that one line") {
  const Folder folder;
  folder.write_mission("standing", "standing");
  check_refused(folder, "missions/m.yaml --set features.min_height_m=16",
                "missions/m.yaml: boxes: no surface above ");
}

TEST_CASE("an output directory that cannot be made or written to is a failure that names it") {
  const Folder folder;
  folder.write("file", "in the way\n");
  const std::string pagoda = std::string(MUSTER_SOURCE_DIR) + "/deploy/missions/pagoda.yaml";
  for (const std::string& out : {folder.path("file/x"), std::string("/proc/muster")}) {
    for (const char* transport : {"dds", "memory"}) {
      const Ended run = folder.run(
          "muster", fmt::format("run '{}' --transport {} --out '{}'", pagoda, transport, out));
      INFO(run.output);
      CHECK(run.status == 1);
      CHECK(run.output.starts_with("--out: "));
      CHECK(run.output.find(": cannot be made: ") != std::string::npos);
      CHECK(is_one_line(run.output));
      CHECK_FALSE(somebody_runs_with(out));
    }
  }
}

TEST_CASE("each program by itself tells what is wrong with its files") {
  const Folder folder;
  const auto refused = [&](const std::string& program, const std::string& arguments,
                           const std::string& complaint, int status = 2) {
    const Ended run = folder.run(program, arguments);
    INFO(program << " " << arguments << "\n" << run.output);
    CHECK(run.status == status);
    CHECK(run.output.starts_with(complaint));
    CHECK(is_one_line(run.output));
  };
  folder.write_mission("time_limit_s:", "time_limit:");
  const std::string unknown = "missions/m.yaml:14: time_limit: unknown key";
  refused("muster-world", "--mission missions/m.yaml --domain 40", unknown);
  refused("muster-commsim", "--mission missions/m.yaml --domain 40", unknown);
  refused("muster-agent", "--mission missions/m.yaml --domain 40 --id 2", unknown);
  refused("muster-gcs", "--mission missions/m.yaml --domain 40 --id 1", unknown);

  folder.write_mission("standing", "standing");
  refused("muster-agent", "--mission missions/m.yaml --domain 40 --id 9",
          "--id: the mission has no robot 9");
  refused("muster-agent", "--mission missions/m.yaml --domain 40 --id 1",
          "--id: robot 1 is a station");
  refused("muster-gcs", "--mission missions/m.yaml --domain 40 --id 2",
          "--id: robot 2 is not a station");
  refused("muster-agent", "--mission missions/m.yaml --domain 40 --id 2 --dds opendds",
          "DDS vendor 'opendds' is not one of ");
  refused("muster-agent", "--fly", "The following argument was not expected: --fly");
  refused("muster-world", "--domain 40", "--mission is required");
  for (const char* hub : {"muster-world", "muster-commsim"})
    refused(hub, "--mission missions/m.yaml --domain 40 --dds opendds",
            "DDS vendor 'opendds' is not one of ");

  folder.write("robot.yaml", "mission: missions/m.yaml\nid: 2\nvendor: cyclonedds\n");
  refused("muster-agent", "--config robot.yaml", "robot.yaml:3: vendor: unknown key; known here: ");
  folder.write("robot.yaml", "mission: missions/m.yaml\nid: 2\ndds: opendds\n");
  refused("muster-agent", "--config robot.yaml", "robot.yaml:3: dds: 'opendds' is not a vendor");
  folder.write("robot.yaml", "mission: nowhere.yaml\nid: 2\nstate_dir: state\n");
  refused("muster-agent", "--config robot.yaml", "nowhere.yaml: cannot be read");
}

TEST_CASE("a domain in use is a failure that names it and the ports") {
  const Folder folder;
  const std::uint32_t domain = muster::test::free_domain();
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(7410 + 250 * domain));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  REQUIRE(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  const std::string pagoda = std::string(MUSTER_SOURCE_DIR) + "/deploy/missions/pagoda.yaml";
  const Ended run = folder.run("muster", fmt::format("run '{}' --domain {} --out '{}'", pagoda,
                                                     domain, folder.path("refused")));
  INFO(run.output);
  CHECK(run.status == 1);
  CHECK(run.output.starts_with(
      fmt::format("--domain: {} is in use: another run holds UDP port ", domain)));
  CHECK(is_one_line(run.output));
  CHECK_FALSE(fs::exists(folder.path("refused")));
  close(fd);
}
