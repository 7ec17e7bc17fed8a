#include "commsim/world/scene_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <bit>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "commsim/world/generator.h"

namespace fs = std::filesystem;

namespace muster::world {
namespace {

std::string ending(const std::string& path) {
  std::string e = fs::path(path).extension().string();
  std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return std::tolower(c); });
  return e;
}

/// Assimp takes a cut ASCII STL for a smaller whole one, so what can be counted is counted here.
void check_stl_is_whole(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const auto size = fs::file_size(path);
  char head[84] = {};
  in.read(head, sizeof head);
  std::uint32_t triangles = 0;
  std::memcpy(&triangles, head + 80, 4);
  if (size >= 84 && size == 84 + 50ull * triangles) return;
  if (std::string(head, 5) != "solid") {
    if (size < 84) throw BadInput(path + ": cut short: not even an STL header");
    throw BadInput(path + ": cut short: " + std::to_string(triangles) + " triangles need " +
                   std::to_string(84 + 50ull * triangles) + " bytes, there are " +
                   std::to_string(size));
  }
  const auto tail = static_cast<std::streamoff>(std::min<std::uintmax_t>(size, 512));
  in.clear();
  in.seekg(-tail, std::ios::end);
  std::string text(static_cast<std::size_t>(tail), ' ');
  in.read(text.data(), tail);
  if (text.find("endsolid") == std::string::npos) {
    throw BadInput(path + ": cut short: 'endsolid' is missing");
  }
}

/// The number of faces that the header of a PLY promises.
std::size_t ply_faces(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  while (std::getline(in, line) && !line.starts_with("end_header")) {
    if (line.starts_with("element face ")) return std::stoul(line.substr(13));
  }
  return 0;
}

/// Collada and glTF come y up from Assimp.
bool is_y_up(const std::string& kind) {
  return kind == ".dae" || kind == ".gltf" || kind == ".glb";
}

/// A cut file can leave faces that name vertices which never came; Assimp's own steps would follow
/// them.
void check_indices(const aiScene& scene, const std::string& path) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& f = mesh.mFaces[i];
      const auto end = f.mIndices + f.mNumIndices;
      if (std::any_of(f.mIndices, end, [&](unsigned v) { return v >= mesh.mNumVertices; })) {
        throw BadInput(path + ": cut short: a face names a vertex that is not there");
      }
    }
  }
}

void append(const aiMesh& from, const aiMatrix4x4& placed, bool y_up, Mesh& mesh) {
  const int first = static_cast<int>(mesh.vertices.size());
  for (unsigned i = 0; i < from.mNumVertices; ++i) {
    const aiVector3D v = placed * from.mVertices[i];
    mesh.vertices.emplace_back(y_up ? Eigen::Vector3f(v.x, -v.z, v.y)
                                    : Eigen::Vector3f(v.x, v.y, v.z));
  }
  for (unsigned i = 0; i < from.mNumFaces; ++i) {
    const aiFace& f = from.mFaces[i];
    if (f.mNumIndices != 3) continue;  // points and lines have no surface
    mesh.triangles.emplace_back(first + static_cast<int>(f.mIndices[0]),
                                first + static_cast<int>(f.mIndices[1]),
                                first + static_cast<int>(f.mIndices[2]));
  }
}

void append(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent, bool y_up,
            Mesh& mesh) {
  const aiMatrix4x4 placed = parent * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    append(*scene.mMeshes[node.mMeshes[i]], placed, y_up, mesh);
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    append(scene, *node.mChildren[i], placed, y_up, mesh);
  }
}

Mesh import(const std::string& path, const std::string& kind) {
  if (kind == ".stl") check_stl_is_whole(path);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  if (!scene || !scene->mRootNode || (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE)) {
    throw BadInput(path + ": cannot be read as " + kind.substr(1) + ": " +
                   importer.GetErrorString());
  }
  check_indices(*scene, path);
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (!scene) throw BadInput(path + ": cannot be cut into triangles");
  Mesh mesh;
  append(*scene, *scene->mRootNode, aiMatrix4x4(), is_y_up(kind), mesh);
  if (kind == ".ply" && mesh.triangles.size() < ply_faces(path)) {
    throw BadInput(path + ": cut short: the header promises " + std::to_string(ply_faces(path)) +
                   " faces, there are " + std::to_string(mesh.triangles.size()));
  }
  return mesh;
}

/// An array of one, as a scene of Assimp owns it.
template <typename T>
T** array_of(std::unique_ptr<T> item) {
  T** items = new T*[1];
  items[0] = item.release();
  return items;
}

std::unique_ptr<aiMesh> for_assimp(const Mesh& mesh) {
  auto out = std::make_unique<aiMesh>();
  out->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  out->mNumVertices = static_cast<unsigned>(mesh.vertices.size());
  out->mVertices = new aiVector3D[mesh.vertices.size()];
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& v = mesh.vertices[i];
    out->mVertices[i] = {v.x(), v.y(), v.z()};
  }
  out->mNumFaces = static_cast<unsigned>(mesh.triangles.size());
  out->mFaces = new aiFace[mesh.triangles.size()];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    out->mFaces[i].mNumIndices = 3;
    out->mFaces[i].mIndices = new unsigned[3];
    for (int k = 0; k < 3; ++k) {
      out->mFaces[i].mIndices[k] = static_cast<unsigned>(mesh.triangles[i][k]);
    }
  }
  return out;
}

}  // namespace

Mesh load_mesh(const std::string& path) {
  static constexpr const char* kKinds[] = {".stl", ".obj", ".ply", ".dae", ".gltf", ".glb"};
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw BadInput(path + ": there is no such file");
  if (fs::file_size(path, error) == 0) throw BadInput(path + ": the file is empty");
  const std::string kind = ending(path);
  Mesh mesh;
  if (kind == ".yaml" || kind == ".yml") {
    mesh = generate(path);
  } else if (std::find(std::begin(kKinds), std::end(kKinds), kind) != std::end(kKinds)) {
    mesh = import(path, kind);
  } else {
    throw BadInput(path + ": '" + kind + "' is not one of .yaml .stl .obj .ply .dae .gltf .glb");
  }
  check_mesh(mesh, path);
  return mesh;
}

void check_mesh(const Mesh& mesh, const std::string& name) {
  if (mesh.triangles.empty()) throw BadInput(name + ": has no triangles");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) {
      throw BadInput(name + ": vertex " + std::to_string(i) +
                     " is not finite: every coordinate must be a number");
    }
  }
  const int count = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (t.minCoeff() < 0 || t.maxCoeff() >= count) {
      throw BadInput(name + ": a triangle names a vertex that is not there");
    }
  }
}

void add_ground(Mesh& mesh, const Vec3& low, const Vec3& high) {
  const int n = static_cast<int>(mesh.vertices.size());
  for (const auto& [x, y] : {std::pair{low.x(), low.y()}, std::pair{high.x(), low.y()},
                             std::pair{high.x(), high.y()}, std::pair{low.x(), high.y()}}) {
    mesh.vertices.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.f);
  }
  mesh.triangles.emplace_back(n, n + 1, n + 2);
  mesh.triangles.emplace_back(n, n + 2, n + 3);
}

void save_mesh(const Mesh& mesh, const std::string& path) {
  static constexpr std::pair<const char*, const char*> kFormats[] = {
      {".obj", "objnomtl"}, {".ply", "plyb"}, {".stl", "stlb"}};
  const std::string kind = ending(path);
  const auto format = std::find_if(std::begin(kFormats), std::end(kFormats),
                                   [&](const auto& f) { return kind == f.first; });
  if (format == std::end(kFormats)) {
    throw BadInput(path + ": '" + kind + "' is not one of .obj .ply .stl");
  }
  // The scene deletes everything hung into it.
  aiScene scene;
  scene.mRootNode = new aiNode("site");
  scene.mRootNode->mNumMeshes = 1;
  scene.mRootNode->mMeshes = new unsigned[1]{0};
  scene.mNumMaterials = 1;
  scene.mMaterials = array_of(std::make_unique<aiMaterial>());
  scene.mNumMeshes = 1;
  scene.mMeshes = array_of(for_assimp(mesh));
  Assimp::Exporter exporter;
  if (exporter.Export(&scene, format->second, path) != aiReturn_SUCCESS) {
    throw Failure(path + ": cannot be written: " + exporter.GetErrorString());
  }
}

}  // namespace muster::world
