#pragma once

#include <string>

#include "commsim/world/scene.h"

namespace muster::world {

/// Reads STL, OBJ, PLY, DAE or glTF (z up, metres), or a YAML recipe. Throws BadInput naming the
/// file when it is missing, of an unknown kind, cut short, empty or not finite.
Mesh load_mesh(const std::string& path);

/// Writes OBJ, PLY or STL, by the ending of `path`. Throws BadInput for another ending, Failure
/// when it cannot be written.
void save_mesh(const Mesh& mesh, const std::string& path);

/// Throws BadInput, beginning with `name`, for a mesh without triangles, with vertices that are not
/// finite, or with indices out of range.
void check_mesh(const Mesh& mesh, const std::string& name);

/// Two triangles at z = 0 under the box.
void add_ground(Mesh& mesh, const Vec3& low, const Vec3& high);

}  // namespace muster::world
