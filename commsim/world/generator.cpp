#include "commsim/world/generator.h"

#include <algorithm>
#include <limits>
#include <map>

#include "commsim/world/generator_parts.h"
#include "commsim/world/scene_file.h"

namespace muster::world {
namespace {

using Builder = void (*)(YamlMap&, Solids&);

const std::map<std::string, Builder>& builders() {
  static const std::map<std::string, Builder> all{
      {"arch", parts::arch},       {"box", parts::box},       {"church", parts::church},
      {"column", parts::column},   {"cone", parts::cone},     {"gable_roof", parts::gable_roof},
      {"gallery", parts::gallery}, {"hall", parts::hall},     {"hip_roof", parts::hip_roof},
      {"house", parts::house},     {"pagoda", parts::pagoda}, {"paifang", parts::paifang},
      {"rampart", parts::rampart}, {"stairs", parts::stairs}, {"tower", parts::tower},
      {"tree", parts::tree},       {"wall", parts::wall},
  };
  return all;
}

struct Place {
  Vec3 at = Vec3::Zero();
  double yaw_deg = 0;
};

/// `at` with `yaw_deg`, or `places`: a list of [x, y, z, yaw_deg] for the same thing several times.
std::vector<Place> read_places(YamlMap& map) {
  Place one;
  map.read("at", one.at);
  map.read("yaw_deg", one.yaw_deg);
  std::vector<std::vector<double>> rows;
  map.read("places", rows);
  if (rows.empty()) return {one};
  std::vector<Place> places;
  for (const auto& r : rows) {
    if (r.size() != 4) map.fail("places", "each is [x, y, z, yaw_deg]");
    places.push_back({one.at + Vec3(r[0], r[1], r[2]), one.yaw_deg + r[3]});
  }
  return places;
}

PartBounds bounds_of(const Mesh& mesh, std::size_t first_vertex, const std::string& name) {
  PartBounds b{name, Vec3::Constant(std::numeric_limits<double>::max()),
               Vec3::Constant(std::numeric_limits<double>::lowest())};
  for (std::size_t i = first_vertex; i < mesh.vertices.size(); ++i) {
    b.low = b.low.cwiseMin(mesh.vertices[i].cast<double>());
    b.high = b.high.cwiseMax(mesh.vertices[i].cast<double>());
  }
  return b;
}

void build(YamlMap map, Solids& out, std::vector<PartBounds>* bounds);

void build_one(YamlMap& map, const std::string& kind, Solids& out) {
  if (kind == "group") {
    for (YamlMap& item : map.list("parts")) build(item, out, nullptr);
    return;
  }
  const auto it = builders().find(kind);
  if (it == builders().end()) {
    std::string names = "group";
    for (const auto& [name, unused] : builders()) names += ", " + name;
    map.fail("kind", "'" + kind + "' is not one of " + names);
  }
  it->second(map, out);
}

void build(YamlMap map, Solids& out, std::vector<PartBounds>* bounds) {
  std::string kind, name;
  map.require("kind", kind);
  map.read("name", name);
  for (const Place& place : read_places(map)) {
    const Solids::Frame here = out.frame();
    const std::size_t first = out.vertex_count();
    out.set_frame(out.nested({place.at, place.yaw_deg * std::numbers::pi / 180}));
    build_one(map, kind, out);
    out.set_frame(here);
    if (bounds && !name.empty()) bounds->push_back(bounds_of(out.mesh(), first, name));
  }
  map.finish();
}

}  // namespace

Mesh generate(const std::string& path, std::vector<PartBounds>* bounds) {
  YamlMap map = YamlMap::load(path);
  Solids out;
  for (YamlMap& item : map.list("parts")) build(item, out, bounds);
  YamlMap ground = map.child("ground");
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  ground.require("low", low);
  ground.require("high", high);
  ground.finish();
  map.finish();
  Mesh mesh = out.take();
  add_ground(mesh, low, high);
  return mesh;
}

}  // namespace muster::world
