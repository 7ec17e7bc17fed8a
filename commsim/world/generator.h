#pragma once

#include <string>
#include <vector>

#include "commsim/world/scene.h"

namespace muster::world {

/// Where one named part of a recipe came to lie.
struct PartBounds {
  std::string name;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
};

/// Builds the mesh that a YAML recipe describes (deploy/scenes/README.md): ground, primitives and
/// whole buildings, each a closed solid; solids may run into each other. Throws BadInput with file,
/// line and key. `bounds`, when given, receives the top-level parts that have a name.
Mesh generate(const std::string& path, std::vector<PartBounds>* bounds = nullptr);

}  // namespace muster::world
