#include "commsim/world/scene.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>

#include "commsim/world/generator.h"
#include "commsim/world/scene_file.h"

using namespace muster;
using namespace muster::world;
namespace fs = std::filesystem;

namespace {

/// A box from (−1, −1, 0) to (1, 1, 2) on the ground.
const char* const kBox =
    "ground: {low: [-10, -10, 0], high: [10, 10, 0]}\n"
    "parts: [{kind: box, name: block, size: [2, 2, 2]}]\n";

class Folder {
 public:
  Folder() { fs::create_directories(dir_); }
  ~Folder() { fs::remove_all(dir_); }
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(dir_ / name, std::ios::binary) << content;
    return path(name);
  }
  std::string path(const std::string& name) const { return (dir_ / name).string(); }
  std::string complaint(const std::string& name, const std::string& content) const {
    const std::string file = write(name, content);
    try {
      Scene::load(file);
      return "none";
    } catch (const BadInput& e) {
      const std::string what = e.what();
      return what.starts_with(file) ? what.substr(file.size()) : "another file: " + what;
    }
  }

 private:
  fs::path dir_ = fs::temp_directory_path() / ("muster_scene_test_" + std::to_string(getpid()));
};

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("a ray meets the first surface and is told its normal towards the origin") {
  const Folder folder;
  const auto scene = Scene::load(folder.write("box.yaml", kBox));
  const auto hit = scene->cast({-5, 0, 1}, {1, 0, 0}, 10);
  REQUIRE(hit);
  CHECK(hit->distance_m == Approx(4));
  CHECK(hit->normal.isApprox(Vec3(-1, 0, 0)));
  CHECK_FALSE(scene->cast({-5, 0, 1}, {1, 0, 0}, 3.9));
  CHECK(scene->cast({-5, 0, 1}, {0, 0, -1}, 3)->distance_m == Approx(1));
}

TEST_CASE("a ray is as long as it is, not as single precision on this processor says") {
  const Folder folder;
  const auto scene = Scene::load(folder.write("box.yaml", kBox));
  for (int i = 0; i < 50; ++i) {
    const Vec3 from(-4.1 - 0.037 * i, 0.3 + 0.011 * i, 1.1),
        to(-1, 0.7 - 0.023 * i, 0.35 + 0.019 * i);
    const auto hit = scene->cast(from, (to - from).normalized(), 20);
    REQUIRE(hit);
    CHECK(hit->distance_m == Approx((to - from).norm()).epsilon(0).margin(1e-12));
  }
}

TEST_CASE("line of sight ends at surfaces, sees points on them and is symmetric") {
  const Folder folder;
  const auto scene = Scene::load(folder.write("box.yaml", kBox));
  CHECK_FALSE(scene->line_of_sight({-5, 0, 1}, {5, 0, 1}));
  CHECK(scene->line_of_sight({-5, 0, 2.5}, {5, 0, 2.5}));
  const Vec3 eye(-4, 1, 1.5), front(-1, 0.3, 1), back(1, 0.3, 1);
  CHECK(scene->line_of_sight(eye, front));
  CHECK(scene->line_of_sight(front, eye));
  CHECK_FALSE(scene->line_of_sight(eye, back));
  CHECK_FALSE(scene->line_of_sight(back, eye));
}

TEST_CASE("clearance is the distance to the nearest surface, up to the cap") {
  const Folder folder;
  const auto scene = Scene::load(folder.write("box.yaml", kBox));
  CHECK(scene->clearance({-2, 0, 1.5}, 5) == Approx(1));
  CHECK(scene->clearance({-2, -2, 1.2}, 5) == Approx(1.2));
  CHECK(scene->clearance({2, 2, 1.45}, 5) == Approx(std::sqrt(2.0)));
  CHECK(scene->clearance({0, 0, 5}, 2) == Approx(2));
}

TEST_CASE("a mesh file that cannot be trusted is refused by name") {
  const Folder folder;
  const auto whole = Scene::load(folder.write("box.yaml", kBox));
  for (const char* name : {"box.stl", "box.ply", "box.obj"}) {
    save_mesh(whole->mesh(), folder.path(name));
    CHECK(Scene::load(folder.path(name))->mesh().triangles.size() ==
          whole->mesh().triangles.size());
  }
  const std::string stl = read(folder.path("box.stl")), ply = read(folder.path("box.ply"));
  CHECK(folder.complaint("cut.stl", stl.substr(0, stl.size() - 30)).starts_with(": cut short: "));
  CHECK(folder.complaint("cut.stl", stl.substr(0, 40)) == ": cut short: not even an STL header");
  CHECK(folder.complaint("cut.stl", "solid a\nfacet normal 0 0 1\nouter loop\n") ==
        ": cut short: 'endsolid' is missing");
  CHECK(folder.complaint("cut.ply", ply.substr(0, ply.size() - 30)) != "none");
  CHECK(folder.complaint("nan.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n") ==
        ": vertex 1 is not finite: every coordinate must be a number");
  std::string nan_stl = stl;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(nan_stl.data() + 84 + 12, &nan, 4);
  CHECK(folder.complaint("nan.stl", nan_stl)
            .ends_with("is not finite: every coordinate must be a number"));
  CHECK(folder.complaint("empty.stl", "") == ": the file is empty");
  CHECK(folder.complaint("points.obj", "v 0 0 0\nv 1 0 0\n") != "none");
  CHECK(folder.complaint("junk.gltf", "{\"asset\": ") != "none");
  CHECK(folder.complaint("junk.xyz", "1 2 3\n").starts_with(": '.xyz' is not one of"));
  CHECK_THROWS_WITH(Scene::load("/nowhere/a.stl"), "/nowhere/a.stl: there is no such file");
}

TEST_CASE("a recipe's mistakes name file, line and key") {
  const Folder folder;
  const std::string ground = "ground: {low: [-1, -1, 0], high: [1, 1, 0]}\n";
  CHECK(folder.complaint("a.yaml", ground + "parts: [{kind: igloo}]\n")
            .starts_with(":2: parts[0].kind: 'igloo' is not one of group, arch, box"));
  CHECK(folder.complaint("a.yaml", ground + "parts: [{kind: box, size: [1, 1, 1], hue: 3}]\n")
            .starts_with(":2: parts[0].hue: unknown key"));
  CHECK(folder.complaint("a.yaml", ground + "parts: [{kind: box, size: [1, -1, 1]}]\n") ==
        ":2: parts[0].size: must be greater than 0 in x, y and z");
  CHECK(folder.complaint("a.yaml", "parts: []\n") != "none");
}

TEST_CASE("every solid of a recipe is closed and faces outwards") {
  const Folder folder;
  for (const char* part : {"box, size: [1, 2, 3]",
                           "column",
                           "cone",
                           "gable_roof",
                           "hip_roof",
                           "arch",
                           "wall, openings: [{x: 0}]",
                           "stairs",
                           "tree",
                           "hall",
                           "hall, tiers: 2, width: 16, depth: 10",
                           "pagoda",
                           "paifang",
                           "gallery",
                           "house",
                           "house, passage: 2.4, jetty: 0.5",
                           "tower",
                           "tower, sides: 8, top: cone",
                           "tower, top: belfry",
                           "church",
                           "rampart",
                           "rampart, gate: 3"}) {
    CAPTURE(part);
    const Mesh mesh = generate(
        folder.write("a.yaml", "ground: {low: [-1, -1, 0], high: [1, 1, 0]}\nparts: [{kind: " +
                                   std::string(part) + ", yaw_deg: 30, at: [3, 4, 0]}]\n"));
    std::map<std::pair<int, int>, int> edges;  // each must be walked once in either direction
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); ++t) {
      for (int i = 0; i < 3; ++i) {
        ++edges[{mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]}];
      }
    }
    bool closed = true;
    for (const auto& [edge, n] : edges) {
      closed = closed && n == 1 && edges.count({edge.second, edge.first}) == 1;
    }
    CHECK(closed);
  }
}
