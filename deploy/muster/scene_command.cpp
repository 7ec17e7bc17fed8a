#include "deploy/muster/scene_command.h"

#include <Eigen/Geometry>
#include <cstdio>
#include <memory>

#include "commsim/world/generator.h"
#include "commsim/world/observable.h"
#include "commsim/world/reachable.h"
#include "commsim/world/scene_file.h"
#include "deploy/muster/scene_render.h"

namespace muster::command {
namespace {

/// A scene file, or the site of a mission file.
struct Site {
  std::optional<mission::Mission> mission;
  std::shared_ptr<const world::Scene> scene;
  std::string scene_file;
};

bool is_yaml(const std::string& file) { return file.ends_with(".yaml") || file.ends_with(".yml"); }

Site load(const std::string& file, const std::vector<std::string>& overrides) {
  Site site;
  site.scene_file = file;
  // A mission has a fleet, a recipe has parts.
  if (is_yaml(file) && !YamlMap::load(file).has("parts")) {
    site.mission = mission::Mission::load(file, overrides);
    site.scene_file = site.mission->scene_file;
    site.scene = world::Scene::load(*site.mission);
  } else {
    site.scene = world::Scene::load(file);
  }
  return site;
}

double area_m2(const world::Mesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int i) -> Vec3 {
      return mesh.vertices[static_cast<std::size_t>(t[i])].cast<double>();
    };
    area += (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm() / 2;
  }
  return area;
}

void print_bounds(const char* what, const Vec3& low, const Vec3& high) {
  std::printf("%-24s x %.2f … %.2f   y %.2f … %.2f   z %.2f … %.2f\n", what, low.x(), high.x(),
              low.y(), high.y(), low.z(), high.z());
}

void print_mission(const Site& site) {
  const mission::Mission& m = *site.mission;
  const world::ReachableSpace reachable(*site.scene, m);
  const world::FeatureSet set = world::draw_features(*site.scene, m, reachable);
  const auto voxels = world::observable_surface(*site.scene, m, reachable);
  std::vector<std::size_t> features(m.boxes.size()), surface(m.boxes.size());
  const auto count = [&](const Vec3& p, std::vector<std::size_t>& per_box) {
    for (std::size_t i = 0; i < m.boxes.size(); ++i) {
      if (m.boxes[i].contains(p, m.resolution_m)) return void(++per_box[i]);
    }
  };
  for (const auto& f : set.features) count(f.position, features);
  for (const auto& v : voxels) {
    count(m.resolution_m * (Vec3(v.x, v.y, v.z) + Vec3::Constant(0.5)), surface);
  }
  print_bounds("hull", m.hull.low(), m.hull.high());
  std::printf("%-24s %.0f m³ of %.0f m³\n", "reachable", reachable.volume_m3(), m.hull.volume());
  std::printf("%-24s %zu, of %u drawn %u rejected (%.1f %%); %zu false areas\n", "features",
              set.features.size(), set.drawn, set.rejected,
              set.drawn ? 100.0 * set.rejected / set.drawn : 0.0, set.decoys.size());
  std::printf("%-24s %zu voxels of %.2f m\n", "observable surface", voxels.size(), m.resolution_m);
  for (std::size_t i = 0; i < m.boxes.size(); ++i) {
    const std::string name = "box " + std::to_string(i);
    print_bounds(name.c_str(), m.boxes[i].low(), m.boxes[i].high());
    std::printf("%-24s %zu features, %zu surface voxels\n", "", features[i], surface[i]);
  }
}

void info(const std::string& file, const std::vector<std::string>& overrides) {
  const Site site = load(file, overrides);
  const world::Mesh& mesh = site.scene->mesh();
  std::printf("%-24s %s\n", "scene", site.scene_file.c_str());
  std::printf("%-24s %zu, area %.0f m²\n", "triangles", mesh.triangles.size(), area_m2(mesh));
  print_bounds("bounds", site.scene->low(), site.scene->high());
  if (is_yaml(site.scene_file)) {
    std::vector<world::PartBounds> parts;
    world::generate(site.scene_file, &parts);
    for (const auto& p : parts) print_bounds(("  " + p.name).c_str(), p.low, p.high);
  }
  if (site.mission) print_mission(site);
}

struct Arguments {
  std::string file, out;
  std::vector<std::string> overrides;
  RenderOptions render;
  std::vector<double> target;
  bool no_features = false;
};

void render_file(const Arguments& a) {
  const Site site = load(a.file, a.overrides);
  RenderOptions options = a.render;
  if (!a.target.empty()) options.target = Vec3(a.target[0], a.target[1], a.target[2]);
  std::vector<world::Feature> features;
  if (site.mission && !a.no_features) {
    features = world::draw_features(*site.scene, *site.mission).features;
  }
  render(*site.scene, site.mission ? &*site.mission : nullptr, features, a.out, options);
}

}  // namespace

void add_scene_command(CLI::App& app) {
  const auto a = std::make_shared<Arguments>();  // lives as long as the callbacks
  CLI::App* scene = app.add_subcommand("scene", "Look at a scene file or at the site of a mission");
  scene->require_subcommand(1);

  CLI::App* i = scene->add_subcommand(
      "info",
      "Triangles, bounds and parts; for a mission also boxes, features and what can be seen");
  i->add_option("file", a->file, "A scene (.yaml .stl .obj .ply .dae .gltf) or a mission")
      ->required();
  i->add_option("--set", a->overrides, "Change a value of the mission: key=value");
  i->callback([a] { info(a->file, a->overrides); });

  CLI::App* c = scene->add_subcommand("convert", "Write a scene as OBJ, PLY or STL");
  c->add_option("in", a->file, "A scene or a mission")->required();
  c->add_option("out", a->out, "What to write: .obj, .ply or .stl")->required();
  c->callback([a] { world::save_mesh(load(a->file, {}).scene->mesh(), a->out); });

  CLI::App* r = scene->add_subcommand(
      "render", "A picture from obliquely above; for a mission with boxes, starts and features");
  r->add_option("file", a->file, "A scene or a mission")->required();
  r->add_option("out", a->out, "The PNG to write")->required();
  r->add_option("--set", a->overrides, "Change a value of the mission: key=value");
  r->add_option("--width", a->render.width, "Pixels")
      ->check(CLI::Range(16, 8000))
      ->capture_default_str();
  r->add_option("--height", a->render.height, "Pixels")
      ->check(CLI::Range(16, 8000))
      ->capture_default_str();
  r->add_option("--azimuth", a->render.azimuth_deg,
                "Where the viewer stands, degrees from +x towards +y")
      ->capture_default_str();
  r->add_option("--elevation", a->render.elevation_deg, "How far above the horizon, degrees")
      ->check(CLI::Range(5.0, 89.0))
      ->capture_default_str();
  r->add_option("--zoom", a->render.zoom, "Enlarge")
      ->check(CLI::Range(0.1, 50.0))
      ->capture_default_str();
  r->add_option("--target", a->target, "Look at x y z")->expected(3);
  r->add_flag("--no-features", a->no_features, "Leave the features out");
  r->callback([a] { render_file(*a); });
}

}  // namespace muster::command
