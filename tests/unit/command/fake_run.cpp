#include "tests/unit/command/fake_run.h"

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

namespace muster::command {
namespace {

using nlohmann::json;

constexpr double kPi = std::numbers::pi;
constexpr int kFeatures = 60;
constexpr double kLost_s = 430;

/// Three storeys with eaves, on columns, on flat ground.
bool solid(double x, double y, double z) {
  if (z < 0.1) return true;
  const double r = std::max(std::abs(x), std::abs(y));
  for (int storey = 0; storey < 3; ++storey) {
    const double floor = 4.0 * storey, half = 4.5 - storey, eaves = half + 1.6;
    const double roof = floor + 3.2 + 0.35 * (eaves - r);
    if (r < eaves && std::abs(z - roof) < 0.2) return true;
    if (storey > 0 && r < half && r > half - 0.25 && z > floor && z < floor + 3.2) return true;
    if (storey == 0 && z < 3.2 && std::abs(std::abs(x) - half) < 0.3 &&
        std::fmod(std::abs(y) + 0.3, 2.0) < 0.6)
      return true;
    if (storey == 0 && z < 3.2 && std::abs(std::abs(y) - half) < 0.3 &&
        std::fmod(std::abs(x) + 0.3, 2.0) < 0.6)
      return true;
  }
  return r < 0.4 && z > 11 && z < 15;
}

void write_map(const std::string& path) {
  octomap::OcTree tree(0.2);
  for (double x = -8.9; x < 9; x += 0.2) {
    for (double y = -9.9; y < 10; y += 0.2) {
      if (std::hypot(x - 8, y + 9) < 3) continue;  // a corner nobody has seen
      for (double z = -0.1; z < 15; z += 0.2) {
        tree.updateNode(octomap::point3d(float(x), float(y), float(z)), solid(x, y, z), true);
      }
    }
  }
  tree.updateInnerOccupancy();
  tree.toMaxLikelihood();
  tree.prune();
  tree.writeBinary(path);
}

struct Doing {
  double x, y, z;
  const char* activity;
};

/// Robot 0: station, 1: explorer, 2…4: inspectors.
Doing doing(int robot, double t, double end_s) {
  const double done = std::min(1.0, t / (0.85 * end_s));
  if (robot == 0) {
    const double phase = std::fmod(t, 150);
    const double side = phase < 100 ? 0 : std::sin((phase - 100) / 50 * kPi);
    return {-8 + 2 * side, -8 + 3 * side, 0.4,
            phase < 100   ? "waiting"
            : phase < 120 ? "travelling"
            : phase < 132 ? "meeting"
                          : "travelling"};
  }
  const double turn =
      robot == 1 ? 14 * kPi * done
                 : (robot - 2) * 2 * kPi / 3 + 8 * kPi * std::max(0.0, done - 0.05 * robot);
  const double r = (robot == 1 ? 7.5 : 6.9) - 2.6 * done + 0.3 * std::sin(9 * turn),
               z = 1 + 11 * done + 0.4 * std::cos(5 * turn);
  const char* activity = robot == 1 ? (std::fmod(t, 75) < 60   ? "exploring"
                                       : std::fmod(t, 75) < 70 ? "travelling"
                                                               : "meeting")
                                    : (std::fmod(t + 13 * robot, 24) < 12 ? "inspecting"
                                       : std::fmod(t, 75) > 70            ? "meeting"
                                                                          : "travelling");
  if (t < 4) activity = "idle";
  if (t > 0.92 * end_s) activity = "returning";
  if (t > 0.98 * end_s) activity = "landed";
  return {r * std::cos(turn), r * std::sin(turn),
          t > 0.92 * end_s ? z * (end_s - t) / (0.08 * end_s) : z, activity};
}

void write_tracks(const std::string& path, double end_s) {
  std::ofstream file(path);
  file << "t_s,robot,x,y,z,yaw_rad,activity\n";
  for (double t = 0; t <= end_s; t += 1) {
    for (int robot = 0; robot < 5; ++robot) {
      const bool lost = robot == 4 && t >= kLost_s;
      const Doing d = doing(robot, lost ? kLost_s : t, end_s);
      file << fmt::format("{:.1f},{},{:.3f},{:.3f},{:.3f},0,{}\n", t, robot, d.x, d.y,
                          lost ? 0.25 : d.z, lost ? "lost" : d.activity);
    }
  }
}

void write_features(const std::string& path, double end_s) {
  std::ofstream file(path);
  file << "id,type,x,y,z,sighted_s,sighted_by,inspected_s,inspected_by,delivered_s\n";
  for (int i = 0; i < kFeatures; ++i) {
    const double k = double(i) / kFeatures, angle = 2.4 * i, r = 5.5 - 3 * k;
    const double sighted = 5 + 0.8 * end_s * k + 6 * std::sin(i),
                 inspected = sighted + 22 + 14 * std::cos(2.0 * i);
    const double delivered = std::ceil(inspected / 75) * 75 + 1;
    const auto late = [&](double t) { return t < end_s ? fmt::format("{:.1f}", t) : ""; };
    file << fmt::format("{},0,{:.3f},{:.3f},{:.3f},{},1,{},{},{}\n", i, r * std::cos(angle),
                        r * std::sin(angle), 1.2 + 11 * k, late(sighted), late(inspected),
                        2 + i % 3, late(delivered));
  }
}

void write_events(const std::string& path, double end_s) {
  std::ofstream file(path);
  file << json{{"t_s", kLost_s},
               {"event", "robot_lost"},
               {"robot", 4},
               {"how", "killed by signal 9"}}
              .dump()
       << '\n'
       << json{{"t_s", end_s}, {"event", "end"}, {"reason", "declared complete"}}.dump() << '\n';
}

json summary(double end_s) {
  json contacts = json::array();
  for (int robot = 2; robot < 5; ++robot) {
    json intervals = json::array();
    for (double t = 70; t < (robot == 4 ? kLost_s : end_s); t += 75)
      intervals.push_back({t + robot, t + robot + 4});
    contacts.push_back({{"robots", {1, robot}}, {"intervals", intervals}});
  }
  json station = json::array();
  for (double t = 120; t < end_s; t += 150) station.push_back({t, t + 12});
  contacts.push_back({{"robots", {0, 1}}, {"intervals", station}});
  return {{"mission", "pagoda"},
          {"strategy", "slei3d"},
          {"seed", 1},
          {"dds", "cyclonedds"},
          {"transport", "dds"},
          {"complete", true},
          {"declared", true},
          {"ended", "declared complete"},
          {"simulated_s", end_s},
          {"t_s", 0.88 * end_s},
          {"t_94_s", 0.8 * end_s},
          {"delivered_time_s", 0.88 * end_s},
          {"finish_time_s", 0.9 * end_s},
          {"home_time_s", nullptr},
          {"finish_rate", 1.0},
          {"features_total", kFeatures},
          {"features_delivered", kFeatures},
          {"areas", {{"true_inspected", 58}, {"false_inspected", 6}, {"duplicate_inspected", 2}}},
          {"map_coverage", 0.9731},
          {"idle_time_s",
           {{"gcs", 310.5}, {"explorers", 122.0}, {"inspectors", 640.25}, {"total", 1072.75}}},
          {"collisions", 0},
          {"min_separation_m", 0.82},
          {"min_clearance_m", 0.14},
          {"air",
           {{"bytes", 18'422'300},
            {"delivered", 24113},
            {"dropped", {{"range", 50121}, {"wall", 8120}}}}},
          {"contacts", contacts},
          {"planning_ms",
           {{"explore", {{"count", 412}, {"mean", 1.84}, {"p95", 4.2}, {"max", 11.9}}},
            {"path", {{"count", 1930}, {"mean", 0.61}, {"p95", 1.7}, {"max", 6.3}}}}},
          {"real_time_factor", 14.2},
          {"cpu_ms_per_robot_s", 8.9},
          {"agent_rss_mb", 31.2},
          {"wall_s", 42.3},
          {"trace_hash", "9f0c1d2e3a4b5c6d"},
          {"robots_lost", {{{"robot", 4}, {"t_s", kLost_s}, {"how", "killed by signal 9"}}}}};
}

}  // namespace

void write_fake_run(const std::string& dir, double end_s) {
  std::filesystem::create_directories(dir);
  write_map(dir + "/map.bt");
  write_tracks(dir + "/tracks.csv", end_s);
  write_features(dir + "/features.csv", end_s);
  write_events(dir + "/events.jsonl", end_s);
  std::ofstream(dir + "/summary.json") << summary(end_s).dump(2) << '\n';
}

}  // namespace muster::command
